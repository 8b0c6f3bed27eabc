"""How deep the surface seems dented just beside the fingertip: the halo without a threshold.

One pixel under the threshold tells nothing, the mean of two hundred does: so the dent can be
followed to where the halo begins, some 20 mm up, where the thresholded signal has long been 0.
"""

from __future__ import annotations

import math

import numpy as np

from halo_service.sensing.revealer import Revealed
from halo_service.values import Fingertip

BACK_PX = 7.0
"""From the finger's end to the middle of its round tip at 0.5 m."""
RING_PX = (9.0, 14.0)
"""Around that middle: beyond the finger's own outline, within the halo (paper 4.3.3: 15 px)."""
HAND_MM = 4.0
"""What reads nearer than this is no surface."""
LEAST_PX = 30
"""Fewer pixels tell nothing: the image's edge, or another finger all around."""
_REACH = math.ceil(RING_PX[1])


def dent_beside(revealed: Revealed, tip: Fingertip) -> float:
    """Return the mean excess ahead of and beside the round tip, mm; nan where it is hidden."""
    dx, dy = tip.tip_px[0] - tip.distal_px[0], tip.tip_px[1] - tip.distal_px[1]
    length = math.hypot(dx, dy)
    if length == 0.0:
        return math.nan
    dx, dy = dx / length, dy / length
    end = revealed.inside(tip.tip_px)
    x, y = end[0] - BACK_PX * dx, end[1] - BACK_PX * dy
    left, top = max(round(x) - _REACH, 0), max(round(y) - _REACH, 0)
    window = revealed.excess_mm[
        top : max(round(y) + _REACH + 1, 0), left : max(round(x) + _REACH + 1, 0)
    ]
    across = np.arange(left, left + window.shape[1]) - x
    down = (np.arange(top, top + window.shape[0]) - y)[:, None]
    away = across**2 + down**2
    ring = (away >= RING_PX[0] ** 2) & (away <= RING_PX[1] ** 2)
    ring &= (across * dx + down * dy > 0.0) & (window > -HAND_MM) & (window != 0.0)
    read = window[ring]
    return float(read.mean()) if read.size >= LEAST_PX else math.nan
