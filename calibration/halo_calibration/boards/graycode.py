"""Gray code: stripes that encode for each camera pixel which projector pixel lights it.

Rule: pictures in, pixels out. Every stripe picture is shown with its inverse, so that neither the
surface's pattern nor the room's light matters: a dim room, where markers drown, is good enough.

Neighbouring stripes differ in one picture alone (that is Gray's code), and where that one cannot
be read the camera's pixel sees their border: then the border is the answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_calibration.boards.board import Picture
from halo_calibration.boards.detect import grey_of
from halo_calibration.errors import CalibrationError
from halo_service.values import Pixels

STRIPE_PX = 4
"""The narrowest difference that is coded. The lights of thousands of pixels are averaged by the
fit, so finer stripes, which a 720p camera cannot see, would win nothing."""
UNSURE = 0.1
"""Of white less black: a smaller difference between a picture and its inverse is noise."""
LEAST_LIGHT = 12.0
"""Grey levels of white less black: six times the camera's noise."""
STEP_PX = 4
"""Every fourth pixel of the camera in both directions."""
LEAST_POINTS = 300
"""A hundredth of the picture, at that step in 720p; less is no picture of a projector."""
WHITE = 250.0
"""A grey level from which nothing can be added."""


@dataclass(frozen=True, slots=True, eq=False)
class Decoded:
    """Which pixel of the projector lights which of the camera."""

    width_px: int
    height_px: int
    """Of the projector's picture."""
    picture: Pixels
    """(N, 2) px of the camera's picture, integers at pixel centres."""
    projector: Pixels
    """(N, 2) px of the projector's, (0, 0) at the outer corner of the top left one."""


def patterns(width_px: int, height_px: int) -> Iterator[Picture]:
    """Yield the (height, width) pictures to show: white, black, then each stripe picture and its
    inverse, columns before rows, widest first."""
    yield np.full((height_px, width_px), 255, np.uint8)
    yield np.zeros((height_px, width_px), np.uint8)
    for size, along in ((width_px, 1), (height_px, 0)):
        code = np.arange(size) // STRIPE_PX
        code ^= code >> 1
        for bit in reversed(range(_bits(size))):
            line = ((code >> bit & 1) * 255).astype(np.uint8)
            stripes = line[None, :] if along else line[:, None]
            shown = np.broadcast_to(stripes, (height_px, width_px)).copy()
            yield shown
            yield np.bitwise_not(shown)


def count(width_px: int, height_px: int) -> int:
    """How many pictures `patterns` yields."""
    return 2 + 2 * (_bits(width_px) + _bits(height_px))


def decode(pictures: Sequence[Picture], width_px: int, height_px: int) -> Decoded:
    """Read the camera's pictures of `patterns`, in their order.

    Each (h, w) or (h, w, 3) uint8. Raises `CalibrationError` with the reason if too little
    can be read.
    """
    if len(pictures) != count(width_px, height_px):
        raise ValueError(f"{len(pictures)} pictures, not {count(width_px, height_px)}")
    grey = [grey_of(each)[::STEP_PX, ::STEP_PX].astype(np.float32) for each in pictures]
    white, black = grey[0], grey[1]
    light = white - black
    good = light > LEAST_LIGHT
    columns = 2 + 2 * _bits(width_px)
    x, x_good = _position(grey[2:columns], light)
    y, y_good = _position(grey[columns:], light)
    good &= x_good & y_good & (x < width_px) & (y < height_px)
    if np.count_nonzero(good) < LEAST_POINTS:
        raise CalibrationError(_why(white, black))
    rows, across = np.nonzero(good)
    seen = np.column_stack([across, rows]).astype(np.float64) * STEP_PX
    return Decoded(width_px, height_px, seen, np.column_stack([x[good], y[good]]))


def _bits(size: int) -> int:
    return int(-(-size // STRIPE_PX) - 1).bit_length()


def _position(
    pairs: Sequence[NDArray[np.float32]], light: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """(h, w) where along one axis each pixel's light comes from, px, and where that is known."""
    bits = len(pairs) // 2
    low = np.zeros(light.shape)
    width = np.full(light.shape, float(STRIPE_PX << bits))
    before = np.zeros(light.shape, dtype=np.bool_)
    sure = np.ones(light.shape, dtype=np.bool_)
    known = np.zeros(light.shape, dtype=np.int64)
    for shown, inverse in zip(pairs[::2], pairs[1::2], strict=True):
        sure &= np.abs(shown - inverse) > UNSURE * light
        before = np.where(sure, before ^ (shown > inverse), before)
        width = np.where(sure, width / 2.0, width)
        low += np.where(sure & before, width, 0.0)
        known += sure
    # A pixel on the border of wide stripes sees both sides, and may be off by the camera's blur.
    return low + width / 2.0, known >= bits - 2


def _why(white: NDArray[np.float32], black: NDArray[np.float32]) -> str:
    if np.mean(black >= WHITE) > 0.02:
        return (
            "the camera's picture is overexposed: dim the lamp, or give the camera a shorter "
            "exposure, and try again"
        )
    if np.mean(white - black > LEAST_LIGHT) < 0.01:
        return (
            "the projector's light is not seen: check that its picture lies in the camera's view, "
            "dim the lamp, and try again"
        )
    return (
        "the stripes cannot be separated: show each picture full screen until the camera has "
        "seen it, focus the projector, let nothing move, and try again"
    )
