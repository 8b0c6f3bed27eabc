"""How far the hand around a fingertip moved between two frames, by registration of their images.

A finger at rest is fast one frame later, and no prediction from its past knows that. The images do:
what is above the surface around a fingertip is searched in the next frame. The finger's own
movement relative to its hand is slow; the measured tip corrects it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Background
from halo_service.sensing.background import excess_depth, thinned
from halo_service.sensing.finger_frame import Pixel
from halo_service.values import Depth

CELL_MM = 3.0
"""Of a map (chosen: a fifth of a finger; with parabolas the place is 0.5 mm off)."""
LOWEST_MM = 4.0
"""What is lower is the surface and its noise (the study's recordings keep what is higher)."""
HIGHEST_MM = 20.0
"""All that is higher counts the same, because hands tilt and rise (chosen: a finger's breadth)."""
AROUND, REACH = 8, 16
"""Cells to each side of a fingertip that are searched for, and how far: 24 mm around it, 48 mm or
1.4 m/s away."""
PAD = AROUND + REACH + 1
LEAST = 30.0 * 5.0**2
"""Less than 30 cells of 5 mm height, in squared heights, cannot be registered (chosen: the end of a
finger that lies flat)."""
MOST_LEFT = 0.5
"""Share of the squared heights that may stay unexplained (measured on the virtual camera: 0.09 in
99 frames of 100, at most 0.45; 1 where the hand is gone)."""
SURPRISE = 0.1 / 24.0**2
"""Share of the squared heights that a mm of squared distance from the expected way is worth: where
two hands cross, both fit (chosen: the hardest start of a hand, 24 mm, is worth a tenth)."""
NEAR = 2
"""Cells around the likeliest place in which the best fit is the way."""
REMEMBERED = 8
"""Frames: the slowest tracker's delay at 30 frames a second."""


@dataclass(frozen=True, slots=True, eq=False)
class HeightMap:
    """What is above the surface in one frame, coarsely."""

    time_us: int
    cells: NDArray[np.float32]
    """(h, w) heights, mm, with `PAD` empty cells to each side."""
    cell_px: int
    cell_mm: float
    """On the surface: `CELL_MM`, rounded to whole pixels."""


def height_map(
    time_us: int, depth: Depth, background: Background, drift_mm: float, px_per_mm: float
) -> HeightMap:
    """Return the map of a frame. `drift_mm`: see `excess_depth`; `px_per_mm`: on the surface."""
    cell_px = max(round(CELL_MM * px_per_mm), 1)
    seen, empty = depth[::cell_px, ::cell_px], thinned(background, cell_px)
    above_mm = np.minimum(-excess_depth(seen, empty, drift_mm), np.float32(HIGHEST_MM))
    above_mm *= above_mm >= LOWEST_MM
    heights = cv2.blur(above_mm, (3, 3))
    padded = cv2.copyMakeBorder(heights, PAD, PAD, PAD, PAD, cv2.BORDER_CONSTANT)
    return HeightMap(time_us, np.asarray(padded, np.float32), cell_px, cell_px / px_per_mm)


def shift_px(
    before: HeightMap, now: HeightMap, place_px: Pixel, expected_px: Pixel = (0.0, 0.0)
) -> Pixel | None:
    """Return how far the hand at a place in the first map moved until the second one.

    `expected_px`: by its velocity. None where nothing is above the surface, or where it is gone.
    """
    column, row = (round(each / now.cell_px) + PAD for each in place_px)
    sought = before.cells[_around(row, AROUND), _around(column, AROUND)]
    where = now.cells[_around(row, AROUND + REACH), _around(column, AROUND + REACH)]
    if where.shape != (2 * (AROUND + REACH) + 1,) * 2:
        return None  # outside the image
    squares = float(np.vdot(sought, sought))
    if squares < LEAST:
        return None
    off = np.asarray(cv2.matchTemplate(where, sought, cv2.TM_SQDIFF), np.float32)
    x, y = (REACH + each / now.cell_px for each in expected_px)
    surprise = np.float32(squares * SURPRISE * now.cell_mm**2) * _distances2(off.shape, x, y)
    row, column = _least(off + surprise)
    # The expectation decides between two hands, not about a millimetre.
    top, left = max(row - NEAR, 0), max(column - NEAR, 0)
    row, column = _least(off[top : row + NEAR + 1, left : column + NEAR + 1])
    row, column = top + row, left + column
    if off[row, column] > MOST_LEFT * squares:
        return None
    height, width = off.shape
    dx = _vertex(*off[row, column - 1 : column + 2]) if 0 < column < width - 1 else 0.0
    dy = _vertex(*off[row - 1 : row + 2, column]) if 0 < row < height - 1 else 0.0
    return (column + dx - REACH) * now.cell_px, (row + dy - REACH) * now.cell_px


def path_px(maps: Sequence[HeightMap], place_px: Pixel, from_us: int) -> Pixel | None:
    """Return how far the hand at a place moved since an earlier frame.

    `maps`: oldest first. None where one of them does not show the hand, or none is as old.
    """
    if not maps or maps[0].time_us > from_us:
        return None
    (x, y), shift = place_px, (0.0, 0.0)
    for before, now in pairwise(each for each in maps if each.time_us >= from_us):
        found = shift_px(before, now, (x, y), shift)
        if found is None:
            return None
        shift = found
        x, y = x + shift[0], y + shift[1]
    return x - place_px[0], y - place_px[1]


def _around(middle: int, cells: int) -> slice:
    return slice(max(middle - cells, 0), max(middle + cells + 1, 0))


def _distances2(shape: tuple[int, ...], x: float, y: float) -> NDArray[np.float32]:
    """Return the squared distance of each cell from a place, in cells."""
    down, right = np.arange(shape[0]) - y, np.arange(shape[1]) - x
    return np.add.outer(down * down, right * right).astype(np.float32)


def _least(values: NDArray[np.float32]) -> tuple[int, int]:
    """Return the row and column of the least value."""
    row, column = divmod(int(np.argmin(values)), values.shape[1])
    return row, column


def _vertex(before: float, least: float, after: float) -> float:
    """Return where a parabola through three neighbours is least, relative to the middle one."""
    bend = before - 2.0 * least + after
    return 0.5 * float(before - after) / float(bend) if bend > 0.0 else 0.0
