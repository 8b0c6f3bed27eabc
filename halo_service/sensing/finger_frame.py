"""Part of an image, read in a finger's own rows and columns: along it, and across."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.detections import Pixel

Floats = NDArray[np.float32]


class Grid(NamedTuple):
    """Where is read, (rows, columns), px from the tip."""

    along: Floats
    """Positive beyond the tip."""
    across: Floats
    """Positive to the right of a finger that points up the image."""


def grid(along: NDArray[np.int_], across: NDArray[np.int_]) -> Grid:
    """Return the grid of all pairs."""
    rows, columns = np.meshgrid(along, across, indexing="ij")
    return Grid(rows.astype(np.float32), columns.astype(np.float32))


def blended(image: Floats, tip: Pixel, direction: Pixel, at: Grid) -> Floats:
    """Read between the pixels, 0 outside. `image`: (h, w) or (h, w, layers); `tip` in it."""
    x, y = _places(tip, direction, at)
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_LINEAR))


def nearest(image: Floats, tip: Pixel, direction: Pixel, at: Grid, outside: float) -> Floats:
    """Read the nearest pixels, and a value outside."""
    x, y = _places(tip, direction, at)
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_NEAREST, borderValue=(outside,)))


def unit(start: Pixel, end: Pixel) -> Pixel:
    """Return the unit vector from one place to another; up the image where they are one."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    return (dx / length, dy / length) if length > 0.0 else (0.0, -1.0)


def moved(point: Pixel, direction: Pixel, along: float, across: float) -> Pixel:
    """Return a point so far along a finger and across it."""
    return (
        point[0] + along * direction[0] - across * direction[1],
        point[1] + along * direction[1] + across * direction[0],
    )


def _places(tip: Pixel, direction: Pixel, at: Grid) -> tuple[Floats, Floats]:
    ux, uy = np.float32(direction[0]), np.float32(direction[1])
    x = at.along * ux - at.across * uy + np.float32(tip[0])
    y = at.along * uy + at.across * ux + np.float32(tip[1])
    return x, y
