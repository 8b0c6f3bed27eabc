"""The mask of all fingers in a part of the image, by depth."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

NEARER_MM = 4.0
"""What is nearer than the surface by this much is finger (chosen: above the noise)."""
STANDS_OUT_MM = 8.0
"""What is nearer than its surroundings by this much is finger too (chosen: half of the least
step between a finger and the dent around it, and above the noise of 3 x 3 pixels)."""
AROUND = np.ones((3, 3), np.uint8)
FILLING_MM = 21.0
"""A valley narrower than this is a finger: 1.5 times the width of a finger."""


def stands_out(excess_mm: NDArray[np.float32], px_per_mm: float) -> NDArray[np.bool_]:
    """Return the mask of what is nearer than the surface, or than the dent around it."""
    smooth = cv2.blur(excess_mm, (3, 3))
    filled = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, _filling(round(FILLING_MM * px_per_mm) | 1))
    above = np.maximum(-smooth, 0.0)
    # The blur spreads a high finger by a pixel to both sides: its edge is where half is left.
    edge = np.maximum(0.5 * cv2.dilate(above, AROUND), NEARER_MM)
    return np.asarray((above > edge) | (filled - smooth > STANDS_OUT_MM))


@lru_cache(maxsize=64)
def _filling(width_px: int) -> NDArray[np.uint8]:
    return np.ones((width_px, width_px), np.uint8)
