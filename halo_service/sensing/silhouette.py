"""Where a finger's mask ends, to a few pixels: where its outline is then sought."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.detections import Pixel
from halo_service.sensing.finger_frame import moved

ROI_PX = 22
"""Half the search window for the silhouette's end: a fast finger's path in one frame."""
NEARER_MM = 4.0
"""What is nearer than the surface by this much is finger (chosen: above the noise)."""
STANDS_OUT_MM = 8.0
"""What is nearer than its surroundings by this much is finger too (chosen: half of the least
step between a finger and the dent around it, and above the noise of 3 x 3 pixels)."""
FILLING = np.ones((21, 21), np.uint8)
"""A valley narrower than this is a finger: 1.5 times the width of a finger at 0.5 m."""
LEAST_HAND_PX = 20
"""Fewer finger pixels in the window are noise."""


def stands_out(excess_mm: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the mask of what is nearer than the surface, or than the dent around it."""
    smooth = cv2.blur(excess_mm, (3, 3))
    filled = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, FILLING)
    return np.asarray((smooth < -NEARER_MM) | (filled - smooth > STANDS_OUT_MM))


def silhouette_end(
    finger: NDArray[np.bool_], guess: Pixel, direction: Pixel, radius_px: float
) -> Pixel | None:
    """Return the end of the finger's mask near a guess, to a few px; None without a finger."""
    tip, half_px = guess, 1.3 * radius_px
    for _ in range(2):  # the second pass looks straight along the finger, the first may be tilted
        left, top = max(round(tip[0]) - ROI_PX, 0), max(round(tip[1]) - ROI_PX, 0)
        window = finger[top : max(top + 2 * ROI_PX, 0), left : max(left + 2 * ROI_PX, 0)]
        rows, columns = np.nonzero(window)
        dx, dy = columns + left - tip[0], rows + top - tip[1]
        along = dx * direction[0] + dy * direction[1]
        across = dy * direction[0] - dx * direction[1]
        near = np.abs(across) <= half_px
        if np.count_nonzero(near) < LEAST_HAND_PX:
            return None
        along, across = along[near], across[near]
        end = float(np.partition(along, -3)[-3])  # the third farthest: two may be stray pixels
        foremost = across[along > end - half_px]
        middle = float(foremost.sum()) / foremost.size
        tip = moved(tip, direction, end, middle)
    return tip
