"""Stage 4: how deep the surface seems dented under a fingertip, the halo without a threshold.

The finger hides the middle of the dent, so its depth is estimated from the visible pixels next to
and ahead of it. There the dent is steep: a fingertip found a millimetre off reads a fifth more or
less. So a round bell is fitted to the hundreds of visible pixels, with a free middle near the pad.
One pixel under the threshold carries no information, all of them together do: the dent is measured
up to where the halo begins, some 20 mm up, where the thresholded signal is long 0.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Profile
from halo_service.sensing.finger_frame import unit
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Fingertip

Floats = NDArray[np.float64]

BELL_PX = 10.0
"""Where a bell of exp(-(r / BELL_PX)^2) has fallen to a third, at 0.5 m: half the patch that holds
a whole halo (paper 4.3.3). 1.5 times as wide is as stable; only the middle must be free."""
RING_PX = (8.0, 18.0)
"""Where it is read: outside the finger's outline, within the halo."""
AHEAD_PX, BACK_PX = 2.0, 5.0
"""The middle is a little ahead of the pad from the outline; what is farther behind the middle is
finger (chosen)."""
EDGE = np.ones((5, 5), np.uint8)
"""Pixels within two of a hand are not surface either: a camera averages along an edge."""
LEAST_PX = 60
"""Fewer pixels do not determine the middle: the image's edge, or another finger all around."""
LEAST_WEIGHT = 2.0
"""Sum of the bell's squares over the read pixels: how well they determine its depth. The far side
of the ring alone fits a bell of any depth (chosen: visible fingers have 3 and more, fingers hidden
but for a rim have 1)."""
NOISE_MM, OFF_PX = 4.0, 5.0
"""Deviations of all pixels together and of the middle: the weight of one over the other (chosen:
neighbours have equal errors)."""
SKIN_MM = 5.0
"""What reads this much less than the bell is not surface (chosen: above the noise)."""
PASSES = 2
"""A third changes nothing."""
_REACH = math.ceil(RING_PX[1])


def dent_under(segmentation: Segmentation, tip: Fingertip, profile: Profile) -> float:
    """Return the depth of the dent's middle, mm, about 0 without one; nan where it is hidden."""
    dx, dy = unit(tip.distal_px, tip.tip_px)
    pad_px = profile.surface.in_picture(np.array([tip.pad_mm]), profile.camera.depth, np.eye(4))
    pad = segmentation.inside((float(pad_px[0, 0]), float(pad_px[0, 1])))
    x, y = pad[0] + AHEAD_PX * dx, pad[1] + AHEAD_PX * dy
    left, top = max(round(x) - _REACH, 0), max(round(y) - _REACH, 0)
    window = np.s_[top : max(round(y) + _REACH + 1, 0), left : max(round(x) + _REACH + 1, 0)]
    excess_mm = segmentation.excess_mm[window]
    if excess_mm.size < LEAST_PX:
        return math.nan
    right = np.arange(left, left + excess_mm.shape[1]) - x
    down = (np.arange(top, top + excess_mm.shape[0]) - y)[:, None]
    along, across = right * dx + down * dy, down * dx - right * dy
    away = right**2 + down**2
    seen = (away >= RING_PX[0] ** 2) & (away <= RING_PX[1] ** 2) & (along > -BACK_PX)
    seen &= (excess_mm != 0.0) & (cv2.erode(segmentation.free[window].astype(np.uint8), EDGE) > 0)
    if np.count_nonzero(seen) < LEAST_PX:
        return math.nan
    return _bell(along[seen], across[seen], excess_mm[seen].astype(np.float64))


def _bell(along: Floats, across: Floats, read_mm: Floats) -> float:
    """Return the depth of the bell that fits best, nan if the visible pixels do not determine it.

    Its middle is free within bounds. The skin of a low fingertip, averaged with the dent next to
    it, can read like the empty surface; it is recognised by its distance from the bell.
    """
    middle = np.zeros(2)
    trust = np.diag([0.0, (NOISE_MM / OFF_PX) ** 2, (NOISE_MM / OFF_PX) ** 2])
    shape, deep_mm = _fitted(along, across, read_mm, middle)
    for _ in range(PASSES):
        pull = 2.0 * deep_mm / BELL_PX**2 * shape
        slopes = np.stack([shape, pull * (along - middle[0]), pull * (across - middle[1])])
        wrong = slopes @ (read_mm - deep_mm * shape) - trust @ np.array([0.0, *middle])
        middle = middle + np.linalg.solve(slopes @ slopes.T + trust, wrong)[1:]
        middle = np.clip(middle, -OFF_PX, OFF_PX)
        shape, deep_mm = _fitted(along, across, read_mm, middle)
        dented = read_mm - deep_mm * shape > -SKIN_MM
        if not dented.all():
            along, across, read_mm = along[dented], across[dented], read_mm[dented]
            shape, deep_mm = _fitted(along, across, read_mm, middle)
    return deep_mm if shape @ shape >= LEAST_WEIGHT else math.nan


def _fitted(along: Floats, across: Floats, read_mm: Floats, middle: Floats) -> tuple[Floats, float]:
    """Return the bell's shape about a middle, 1 there, and the depth that fits best."""
    shape = np.exp(-((along - middle[0]) ** 2 + (across - middle[1]) ** 2) / BELL_PX**2)
    return shape, float(shape @ read_mm / (shape @ shape))
