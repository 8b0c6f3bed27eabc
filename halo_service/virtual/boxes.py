"""Parts of an image: rows and columns in which something is.

Rule: a box ends inside its image.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Box = tuple[slice, slice]
"""Rows and columns."""


def box_of(mask: NDArray[np.uint8]) -> Box | None:
    """Where a mask is not 0; None: nowhere."""
    x, y, width, height = cv2.boundingRect(mask)
    return (slice(y, y + height), slice(x, x + width)) if width else None


def clipped(
    low: tuple[float, float] | NDArray[np.float64],
    high: tuple[float, float] | NDArray[np.float64],
    shape: tuple[int, ...],
) -> Box:
    """Rows and columns from two corners (x, y), within the image."""
    (x0, y0), (x1, y1) = low, high
    rows = slice(max(0, int(y0)), max(0, min(shape[0], int(y1) + 1)))
    return rows, slice(max(0, int(x0)), max(0, min(shape[1], int(x1) + 1)))


def grown(box: Box, margin_px: int, above_px: int | None, shape: tuple[int, ...]) -> Box:
    """A box with a margin, above and below `above_px` (None: the same)."""
    rows, columns = box
    above_px = margin_px if above_px is None else above_px
    return (
        slice(max(0, rows.start - above_px), min(shape[0], rows.stop + above_px)),
        slice(max(0, columns.start - margin_px), min(shape[1], columns.stop + margin_px)),
    )


def union(boxes: Sequence[Box | None]) -> Box | None:
    """The smallest box around all that is in boxes; None: nothing is."""
    there = [box for box in boxes if box and all(side.start < side.stop for side in box)]
    if not there:
        return None
    rows, columns = zip(*there, strict=True)
    return _span(rows), _span(columns)


def within(box: Box, outer: Box) -> Box:
    """A box in the rows and columns of one around it."""
    (rows, columns), (top, left) = box, (side.start for side in outer)
    return (
        slice(rows.start - top, rows.stop - top),
        slice(columns.start - left, columns.stop - left),
    )


def _span(slices: Sequence[slice]) -> slice:
    return slice(min(s.start for s in slices), max(s.stop for s in slices))
