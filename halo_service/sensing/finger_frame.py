"""Part of an image, read in a finger's own rows and columns: along it, and across, in mm."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Pixel = tuple[float, float]
Floats = NDArray[np.float32]


class FingerFrame(NamedTuple):
    """Where a fingertip is in the image, where it points, and how large a millimetre is there."""

    tip_px: Pixel
    direction: Pixel
    """Unit vector from joint to tip."""
    px_per_mm: float
    """At the finger's own depth."""

    def moved(self, along_mm: float, across_mm: float = 0.0) -> FingerFrame:
        """Return the frame of a tip so far along this finger and across it."""
        along, across = along_mm * self.px_per_mm, across_mm * self.px_per_mm
        (x, y), (dx, dy) = self.tip_px, self.direction
        tip_px = x + along * dx - across * dy, y + along * dy + across * dx
        return FingerFrame(tip_px, self.direction, self.px_per_mm)

    def turned(self, radians: float) -> FingerFrame:
        """Return the frame of a finger that points so far to the right of this one."""
        (dx, dy), cosine, sine = self.direction, math.cos(radians), math.sin(radians)
        direction = cosine * dx - sine * dy, sine * dx + cosine * dy
        return FingerFrame(self.tip_px, direction, self.px_per_mm)

    def away_mm(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return how far pixels are along this finger from its tip, and across it, mm."""
        size = np.float32(self.px_per_mm)
        right, down = (
            (x - np.float32(self.tip_px[0])) / size,
            (y - np.float32(self.tip_px[1])) / size,
        )
        ux, uy = np.float32(self.direction[0]), np.float32(self.direction[1])
        return right * ux + down * uy, down * ux - right * uy


class Grid(NamedTuple):
    """Where is read, mm from the tip. Both are (rows, columns), or broadcast to it."""

    along: Floats
    """Positive beyond the tip."""
    across: Floats
    """Positive to the right of a finger that points up the image."""


def grid(along: NDArray[np.int_], across: NDArray[np.int_]) -> Grid:
    """Return the grid of all pairs: (rows, 1) and (1, columns), which are cheap to turn."""
    return Grid(along[:, None].astype(np.float32), across[None].astype(np.float32))


def blended(image: Floats, place: FingerFrame, at: Grid) -> Floats:
    """Read between the pixels, 0 outside. `image`: (h, w) or (h, w, layers); `place` in it."""
    x, y = _pixels(place, at)
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_LINEAR))


def nearest(image: NDArray[Any], place: FingerFrame, at: Grid, outside: float) -> NDArray[Any]:
    """Read the nearest pixels, and a value outside."""
    x, y = _pixels(place, at)
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_NEAREST, borderValue=(outside,)))


def unit(start: Pixel, end: Pixel) -> Pixel:
    """Return the unit vector from one place to another; up the image where they are one."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    return (dx / length, dy / length) if length > 0.0 else (0.0, -1.0)


def _pixels(place: FingerFrame, at: Grid) -> tuple[Floats, Floats]:
    (left, top), size = place.tip_px, place.px_per_mm
    ux, uy = np.float32(size * place.direction[0]), np.float32(size * place.direction[1])
    x, y = at.along * ux - at.across * uy, at.along * uy + at.across * ux
    x += np.float32(left)
    y += np.float32(top)
    return x, y
