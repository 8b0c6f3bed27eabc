"""The picture of one region for the hand model: infrared, shaded by height above the surface.

Rule: pure. Infrared does not see what a projector throws. Height makes a hand stand out where it
is as bright as the table: it is worth more to the model than colour, and costs no JPEG.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.hand_tracking.regions import AROUND_HAND_MM, REGION_MM, Heights, Region
from halo_service.values import Hand, Infrared, Pixels

Grey = NDArray[np.uint8]

SIZE_PX = 256
"""Side of a picture: the model itself works at 192 and 224."""
MM_PER_PX = REGION_MM / SIZE_PX
"""Of a picture."""
LOW_MM = 4.0
"""From this height on a pixel is the hand's: above the noise, below a touching finger."""
DIM = 1.0
"""Brightness of the surface beside the hand's: the model sees fingers against it, and touching
fingertips, which read as low as the surface, do not vanish."""
GROUND = 30.0
"""Grey of the hand at the surface."""
SHADE, HIGHEST_MM = 0.5, 100.0
"""Grey per mm of height, up to this height."""
RELIEF, RELIEF_MM, RELIEF_PX = 3.0, 20.0, (31, 31)
"""Grey per mm above the hand's mean height in this window, and how far that counts: it shows the
fingers apart where they are as bright as the back of the hand (of 64 virtual frames in which the
model starts anew, it finds all; without it, 57)."""
DARK = 15
"""Grey of what holds nothing."""
TONES = 100.0
"""Grey between the darkest and the brightest infrared of the hand."""
LEAST_PX = 50
"""Fewer hand pixels have no brightness."""


def region_picture(
    height_mm: Heights, ir: Infrared, region: Region, hidden: Sequence[Hand] = ()
) -> Grey | None:
    """Return (`SIZE_PX`, `SIZE_PX`) uint8 of a region; None where nothing is above the surface.

    Beyond the image's edge it is dark, and so are the hands in `hidden`: where the model looks for
    one more hand, it would find these again.
    """
    onto = to_picture(region)
    size = (SIZE_PX, SIZE_PX)
    height: Heights = np.asarray(cv2.warpAffine(height_mm, onto, size), np.float32)
    tone = np.sqrt(cv2.warpAffine(ir, onto, size), dtype=np.float32)
    hand = np.asarray(cv2.blur(height, (5, 5)) > LOW_MM)
    if np.count_nonzero(hand) < LEAST_PX:
        return None
    dark, bright = np.percentile(tone[hand], (2.0, 98.0))
    low, high = 0.6 * dark, 1.15 * bright
    tone = np.clip((tone - np.float32(low)) / np.float32(max(high - low, 1.0)), 0.0, 1.0) * TONES
    picture = (DARK + DIM * tone).astype(np.uint8)
    part = _around(hand)
    hand, height, tone = hand[part], height[part], tone[part]
    bright_hand = tone + GROUND + SHADE * np.clip(height, 0.0, HIGHEST_MM) + _relief(height, hand)
    np.copyto(picture[part], np.clip(bright_hand, 0, 255).astype(np.uint8), where=hand)
    for other in hidden:
        hull = cv2.convexHull(_in_picture(other.landmarks_px, region).astype(np.float32))
        outline = np.rint(hull).astype(np.int32)
        cv2.fillConvexPoly(picture, outline, (DARK,))
        around_px = 2.0 * AROUND_HAND_MM / REGION_MM * SIZE_PX
        cv2.polylines(picture, [outline], True, (DARK,), round(around_px))
    return picture


def _around(hand: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and columns that hold a hand and all that its relief is compared with."""
    left, top, width, height = cv2.boundingRect(hand.view(np.uint8))
    reach_x, reach_y = (each // 2 for each in RELIEF_PX)
    return (
        slice(max(top - reach_y, 0), top + height + reach_y),
        slice(max(left - reach_x, 0), left + width + reach_x),
    )


def _relief(height_mm: Heights, hand: NDArray[np.bool_]) -> Heights:
    """Return the grey that a hand's own relief adds, within the hand."""
    weight = hand.astype(np.float32)
    share = np.maximum(cv2.blur(weight, RELIEF_PX), np.float32(0.05))
    mean_mm = cv2.blur(height_mm * weight, RELIEF_PX) / share
    return np.asarray(RELIEF * np.clip(height_mm - mean_mm, -RELIEF_MM, RELIEF_MM))


def _in_picture(image_px: Pixels, region: Region) -> Pixels:
    onto = to_picture(region)
    return np.asarray(image_px * onto[0, 0] + onto[:, 2])


def in_image(picture_px: Pixels, region: Region) -> Pixels:
    """Return places of a region's picture, (N, 2) px, in the image that it was cut from."""
    onto = to_picture(region)
    return np.asarray((picture_px - onto[:, 2]) / onto[0, 0])


def to_picture(region: Region) -> NDArray[np.float64]:
    """Return the (2, 3) map from the image's pixel centres to the picture's."""
    scale = SIZE_PX / region.side_px
    middle = (SIZE_PX - 1) / 2.0
    return np.array(
        [[scale, 0.0, middle - scale * region.x_px], [0.0, scale, middle - scale * region.y_px]]
    )
