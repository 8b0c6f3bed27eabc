"""Where a finger's mask ends, to a few pixels: where its outline is then sought."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.finger_frame import FingerFrame

ROI_MM = 22.0
"""Half the search window for the silhouette's end: a fast finger's path in one frame."""
NEARER_MM = 4.0
"""What is nearer than the surface by this much is finger (chosen: above the noise)."""
STANDS_OUT_MM = 8.0
"""What is nearer than its surroundings by this much is finger too (chosen: half of the least
step between a finger and the dent around it, and above the noise of 3 x 3 pixels)."""
FILLING_MM = 21.0
"""A valley narrower than this is a finger: 1.5 times the width of a finger."""
LEAST_HAND_MM2 = 20.0
"""Less finger in the window is noise."""


def stands_out(excess_mm: NDArray[np.float32], px_per_mm: float) -> NDArray[np.bool_]:
    """Return the mask of what is nearer than the surface, or than the dent around it."""
    smooth = cv2.blur(excess_mm, (3, 3))
    filled = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, _filling(round(FILLING_MM * px_per_mm) | 1))
    return np.asarray((smooth < -NEARER_MM) | (filled - smooth > STANDS_OUT_MM))


def silhouette_end(
    finger: NDArray[np.bool_], guess: FingerFrame, radius_mm: float
) -> FingerFrame | None:
    """Return the end of the finger's mask near a guess, to a few px; None without a finger."""
    place, half_mm, roi_px = guess, 1.3 * radius_mm, round(ROI_MM * guess.px_per_mm)
    for _ in range(2):  # the second pass looks straight along the finger, the first may be tilted
        x, y = (round(each) for each in place.tip_px)
        left, top = max(x - roi_px, 0), max(y - roi_px, 0)
        rows, columns = np.nonzero(
            finger[top : max(top + 2 * roi_px, 0), left : max(left + 2 * roi_px, 0)]
        )
        along, across = place.away_mm(
            (columns + left).astype(np.float32), (rows + top).astype(np.float32)
        )
        near = np.abs(across) <= half_mm
        if np.count_nonzero(near) < LEAST_HAND_MM2 * guess.px_per_mm**2:
            return None
        along, across = along[near], across[near]
        end = float(np.partition(along, -3)[-3])  # the third farthest: two may be stray pixels
        place = place.moved(end, float(np.mean(across[along > end - half_mm])))
    return place


@lru_cache(maxsize=64)
def _filling(width_px: int) -> NDArray[np.uint8]:
    return np.ones((width_px, width_px), np.uint8)
