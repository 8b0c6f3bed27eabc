"""Draw a stroke into its layer: discs from point to point, with edges soft over one pixel.

Rule: pure NumPy; the opacity of one stroke. Where its parts overlap, the larger opacity counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from halo_client import PictureTransform
from halo_paint.brushes import Array
from halo_paint.stroke import Piece, Stroke

Layer = NDArray[np.float32]
"""(H, W) opacity, 0 to 1."""
Box = tuple[slice, slice]
"""Rows and columns."""

STEP = 0.3
"""Distance between discs, relative to their radius."""
LEAST_PX = 0.35
"""Smallest radius of a disc: a thinner line would vanish between pixels."""
HALF = 64
"""Number of steps of the strands' table on each side of the middle."""
SHARP = 0.5
"""Visible share of a disc above which the whole disc is drawn."""
SOFT = 0.5
"""Width of the transition between two strands, relative to a strand."""


@dataclass(frozen=True, slots=True)
class _Disc:
    """A point of a stroke, px."""

    x: float
    y: float
    radius: float
    ink: Array
    """(bristles,) opacity."""


def sweep(layer: Layer, placing: PictureTransform, stroke: Stroke, drawn: int = 0) -> Box | None:
    """Draw a stroke's pieces from number `drawn` on; return the box that changed, or None."""
    pieces = stroke.pieces
    opened = _opening(pieces[drawn - 1], -2, -1) if drawn else math.inf
    boxes = []
    for n in range(drawn, len(pieces)):
        ends_here = stroke.done and n == len(pieces) - 1
        boxes.append(_sweep(layer, placing, pieces[n], opened, ends_here))
        opened = _opening(pieces[n], -2, -1)
    return around(boxes)


def _sweep(
    layer: Layer, placing: PictureTransform, piece: Piece, opened: float, ends_here: bool
) -> Box | None:
    """`opened`: of the disc where the piece begins, see `_opening`."""
    x, y = np.array([placing.pixel(*at) for at in zip(piece.x, piece.y, strict=True)]).T
    scale = placing.scale(float(piece.x[-1]), float(piece.y[-1]))
    radius = np.maximum(piece.radius * scale, LEAST_PX)
    stops = _stops(x, y, radius)
    boxes = []
    for begin, end in pairwise(stops):
        here, there = (_Disc(x[n], y[n], radius[n], piece.ink[n]) for n in (begin, end))
        opening = _opening(piece, begin, end)
        direction = float(piece.direction[end])
        if max(opened, opening) > SHARP:
            boxes.append(_stretch(layer, here, here, direction, math.inf))
        boxes.append(_stretch(layer, here, there, direction, 1.0 + opening * there.radius))
        opened = opening
    if ends_here:
        boxes.append(_stretch(layer, there, there, direction, math.inf))
    return around(boxes)


def _opening(piece: Piece, begin: int, end: int) -> float:
    """Visible share of the disc between two stretches, 0 to 1: where a stroke turns or narrows."""
    turn = abs(math.remainder(piece.direction[end] - piece.direction[begin], 2 * math.pi))
    way = math.hypot(piece.x[end] - piece.x[begin], piece.y[end] - piece.y[begin])
    narrowing = abs(piece.radius[end] - piece.radius[begin]) / max(way, 1e-6)
    return min(1.0, turn + float(narrowing))


def _stops(x: Array, y: Array, radius: Array) -> list[int]:
    """Indices of points to draw: first, last, and others by their distance and radius."""
    stops = [0]
    for n in range(1, len(x)):
        begin = stops[-1]
        far = np.hypot(x[n] - x[begin], y[n] - y[begin]) >= max(1.0, STEP * radius[n])
        if far or n == len(x) - 1:
            stops.append(n)
    return stops


def _stretch(
    layer: Layer, begin: _Disc, end: _Disc, direction: float, beyond_px: float
) -> Box | None:
    """Draw from one disc to the next, with radius and ink interpolated.

    `direction`: of the stroke, used if the two discs coincide. `beyond_px`: how far strands may
    extend beyond the two points, because a wet stretch must not fill a dry neighbour.
    """
    box = _reached(layer, begin, end)
    if box is None:
        return None
    # Relative to the first disc, at pixel centres.
    x = np.arange(box[1].start, box[1].stop, dtype=np.float32) + np.float32(0.5 - begin.x)
    y = np.arange(box[0].start, box[0].stop, dtype=np.float32)[:, None] + np.float32(0.5 - begin.y)
    dx, dy = np.float32(end.x - begin.x), np.float32(end.y - begin.y)
    way = np.float32(max(float(dx * dx + dy * dy), 1e-6))
    along = (x * dx + y * dy) / way
    t = np.clip(along, 0, 1)
    radius = np.float32(begin.radius) + np.float32(end.radius - begin.radius) * t
    opacity = np.clip(radius - np.hypot(x - t * dx, y - t * dy) + np.float32(0.5), 0, 1)
    if len(end.ink) == 1:
        opacity *= np.float32(end.ink[0])
    else:
        within_px = np.sqrt(way) * np.minimum(along, 1 - along)
        opacity *= np.clip(within_px + np.float32(beyond_px), 0, 1)
        if way > 1e-3:  # In pixels, because a homography may rotate it.
            direction = float(np.arctan2(dy, dx))
        across = np.float32(np.cos(direction)) * y - np.float32(np.sin(direction)) * x
        strand = np.clip((across / radius + 1) * HALF, 0, 2 * HALF).astype(np.intp)
        here, there = (_across(disc.ink)[strand] for disc in (begin, end))
        opacity *= here + (there - here) * t
    np.maximum(layer[box], opacity, out=layer[box])
    return box


def _across(ink: Array) -> NDArray[np.float32]:
    """Return the ink across a stroke, from its left to its right edge."""
    count = len(ink)
    places = np.linspace(-0.5, count - 0.5, 2 * HALF + 1)
    left = np.floor(places)
    part = np.clip((places - left - 0.5) / SOFT + 0.5, 0.0, 1.0)
    here, next_to = (ink[np.clip(left + n, 0, count - 1).astype(np.intp)] for n in (0, 1))
    table: NDArray[np.float32] = (here + (next_to - here) * part).astype(np.float32)
    return table


def _reached(layer: Layer, begin: _Disc, end: _Disc) -> Box | None:
    """Box of the pixels that a stretch may change; None outside the layer."""
    height, width = layer.shape
    reach = max(begin.radius, end.radius) + 1.0
    left, right = (round(f(begin.x, end.x) + s * reach) for f, s in ((min, -1), (max, 1)))
    top, low = (round(f(begin.y, end.y) + s * reach) for f, s in ((min, -1), (max, 1)))
    box = slice(max(top, 0), min(low + 1, height)), slice(max(left, 0), min(right + 1, width))
    return None if box[0].start >= box[0].stop or box[1].start >= box[1].stop else box


def around(parts: Iterable[Box | None]) -> Box | None:
    """Return the box around all boxes, or None without any."""
    boxes = [box for box in parts if box is not None]
    if not boxes:
        return None
    rows, columns = ([box[n] for box in boxes] for n in (0, 1))
    return (
        slice(min(s.start for s in rows), max(s.stop for s in rows)),
        slice(min(s.start for s in columns), max(s.stop for s in columns)),
    )


def meet(box: Box, other: Box | None) -> bool:
    """Whether two boxes share a pixel."""
    return other is not None and all(
        a.start < b.stop and b.start < a.stop for a, b in zip(box, other, strict=True)
    )
