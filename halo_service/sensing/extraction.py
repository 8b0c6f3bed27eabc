"""Stage 4, as in the paper: the sum of the halo in a patch around one fingertip.

Its patch is in pixels, so that older profiles keep their meaning; the other readings are in mm.
"""

from __future__ import annotations

import numpy as np

from halo_service.sensing.finger_frame import unit
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Fingertip

PATCH_WIDTH_PX = 30
PATCH_HEIGHT_PX = 20
"""The patch that holds a whole halo at 0.5 m (paper 4.3.3)."""
ACROSS = np.arange(PATCH_WIDTH_PX) - PATCH_WIDTH_PX // 2
ALONG = PATCH_HEIGHT_PX // 2 - np.arange(PATCH_HEIGHT_PX)[:, None]
"""The patch's columns across the finger and its rows along it, px from the tip."""
FREE_PX = 493
"""Pixels of the patch that a lone finger leaves free (chosen: it hides a sixth)."""
LEAST_FREE_PX = 120
"""Fewest free pixels that are scaled up to the whole patch: a quarter."""


def extract(segmentation: Segmentation, tip: Fingertip) -> float:
    """Sum the excess depth of the halo pixels in the patch around the tip, mm px.

    The patch lies across the finger. If more of it is hidden than by a single finger (by the hand,
    a neighbour or pixels without a measurement), the rest is scaled up to the whole.
    """
    dx, dy = unit(tip.distal_px, tip.tip_px)
    end = segmentation.inside(tip.tip_px)
    # The middle of a finger is often on a pixel's middle, and its end between two pixels. A quarter
    # of a pixel from both, the same pixels are read in each frame.
    x = np.floor(end[0] + 0.25 + ALONG * dx - ACROSS * dy).astype(np.intp)
    y = np.floor(end[1] + 0.25 + ALONG * dy + ACROSS * dx).astype(np.intp)
    height, width = segmentation.halo.shape
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    x, y = x[inside], y[inside]
    signal = float(segmentation.excess_mm[y, x][segmentation.halo[y, x]].sum())
    free = np.count_nonzero(segmentation.free[y, x])
    return signal * FREE_PX / max(free, LEAST_FREE_PX)
