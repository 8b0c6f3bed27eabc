"""Strokes as pixels.

Rule: pure NumPy. A stroke has a layer of its own, in which its parts never add up, so that it
can cross itself without a seam; layers are laid over the paper as long as they are painted, and
become part of it when they end. Edges are soft over one pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_client import Placing
from halo_paint.brushes import PAPER, Colour
from halo_paint.stroke import Piece, Stroke

Pixels = NDArray[np.uint8]
"""(H, W, 3) red, green, blue."""
Layer = NDArray[np.float32]
"""(H, W) opacity, 0 to 1."""
Box = tuple[slice, slice]
"""Rows and columns."""

STEP = 0.3
"""Distance of the discs that a stroke is swept with, over their radius."""


@dataclass(slots=True)
class _Wet:
    """A stroke that is being painted."""

    layer: Layer
    drawn: int = 0
    """Pieces in the layer."""


class Canvas:
    """A paper of so many pixels, and where the surface is on it."""

    def __init__(self, width: int, height: int, placing: Placing, paper: Colour = PAPER) -> None:
        self.placing = placing
        self._dry = np.empty((height, width, 3), np.uint8)
        self._dry[:] = paper
        self.pixels: Pixels = self._dry.copy()
        """The picture as it is to be seen."""
        self._paper = paper
        self._wet: dict[int, tuple[Stroke, _Wet]] = {}

    def grow(self, stroke: Stroke) -> Box | None:
        """Draw what is new of a stroke; returns where the picture changed."""
        if id(stroke) not in self._wet:
            self._wet[id(stroke)] = stroke, _Wet(self._empty())
        _, wet = self._wet[id(stroke)]
        boxes = [sweep(wet.layer, self.placing, piece) for piece in stroke.pieces[wet.drawn :]]
        wet.drawn = len(stroke.pieces)
        box = _around([box for box in boxes if box is not None])
        if box is not None:
            self._show(box)
        return box

    def dry(self, stroke: Stroke) -> None:
        """A stroke has ended: it becomes part of the paper."""
        _, wet = self._wet.pop(id(stroke))
        box = _inked(wet.layer)
        if box is not None:
            self._dry[box] = over(self._dry[box], wet.layer[box], stroke.colour)
            self._show(box)

    def repaint(self, strokes: list[Stroke]) -> None:
        """Begin anew with finished strokes; those that are being painted stay."""
        self._dry[:] = self._paper
        for stroke in strokes:
            layer = self._empty()
            for piece in stroke.pieces:
                sweep(layer, self.placing, piece)
            box = _inked(layer)
            if box is not None:
                self._dry[box] = over(self._dry[box], layer[box], stroke.colour)
        self._show((slice(None), slice(None)))

    def _show(self, box: Box) -> None:
        pixels = self._dry[box]
        for stroke, wet in self._wet.values():
            pixels = over(pixels, wet.layer[box], stroke.colour)
        self.pixels[box] = pixels

    def _empty(self) -> Layer:
        return np.zeros(self._dry.shape[:2], np.float32)


def over(below: Pixels, layer: Layer, colour: Colour) -> Pixels:
    """A colour laid over a picture."""
    opacity = layer[..., None]
    mixed = below * (1 - opacity) + np.array(colour, np.float32) * opacity
    laid: Pixels = np.round(mixed).astype(np.uint8)
    return laid


def sweep(layer: Layer, placing: Placing, piece: Piece) -> Box | None:
    """Draw a piece into its stroke's layer; returns where."""
    x, y = np.array([placing.pixel(*at) for at in zip(piece.x, piece.y, strict=True)]).T
    scale = placing.scale(float(piece.x[-1]), float(piece.y[-1]))
    radius = np.maximum(piece.radius * scale, 0.35)
    boxes, begin = [], 0
    for end in _stops(x, y, radius):
        ends = [(x[n], y[n], radius[n]) for n in (begin, end)]
        boxes.append(_stretch(layer, ends[0], ends[1], piece.direction[end], piece.ink[end]))
        begin = end
    return _around([box for box in boxes if box is not None])


def _stops(
    x: NDArray[np.float64], y: NDArray[np.float64], radius: NDArray[np.float64]
) -> list[int]:
    """The points to draw to: near enough to each other for their size, and the last."""
    stops, begin = [], 0
    for n in range(1, len(x)):
        far = np.hypot(x[n] - x[begin], y[n] - y[begin]) >= max(1.0, STEP * radius[n])
        if far or n == len(x) - 1:
            stops.append(n)
            begin = n
    return stops


def _stretch(
    layer: Layer,
    begin: tuple[float, float, float],
    end: tuple[float, float, float],
    direction: float,
    ink: NDArray[np.float64],
) -> Box | None:
    """A disc drawn from one place to the next, its radius changing on the way."""
    reach = max(begin[2], end[2]) + 1.0
    height, width = layer.shape
    left, right = (round(f(begin[0], end[0]) + s * reach) for f, s in ((min, -1), (max, 1)))
    top, low = (round(f(begin[1], end[1]) + s * reach) for f, s in ((min, -1), (max, 1)))
    box = slice(max(top, 0), min(low + 1, height)), slice(max(left, 0), min(right + 1, width))
    if box[0].start >= box[0].stop or box[1].start >= box[1].stop:
        return None
    # Relative to the beginning, at the pixels' centres.
    x = np.arange(box[1].start, box[1].stop, dtype=np.float32) + np.float32(0.5 - begin[0])
    y = (np.arange(box[0].start, box[0].stop, dtype=np.float32) + np.float32(0.5 - begin[1]))[
        :, None
    ]
    dx, dy = np.float32(end[0] - begin[0]), np.float32(end[1] - begin[1])
    way = max(float(dx * dx + dy * dy), 1e-6)
    t = np.clip((x * dx + y * dy) / np.float32(way), 0, 1)
    radius = np.float32(begin[2]) + np.float32(end[2] - begin[2]) * t
    opacity = np.clip(radius - np.hypot(x - t * dx, y - t * dy) + np.float32(0.5), 0, 1)
    if len(ink) == 1:
        opacity *= np.float32(ink[0])
    else:
        if way > 1e-3:  # In pixels a homography may have turned it.
            direction = np.arctan2(dy, dx)
        aside = (np.float32(np.cos(direction)) * y - np.float32(np.sin(direction)) * x) / radius
        opacity *= _strands(ink)[np.clip((aside + 1) * _HALF, 0, 2 * _HALF).astype(np.intp)]
    np.maximum(layer[box], opacity, out=layer[box])
    return box


_HALF = 32
"""Steps of the strands' table to either side of the middle."""


def _strands(ink: NDArray[np.float64]) -> NDArray[np.float32]:
    """The ink across a stroke, from its left edge to its right one."""
    places = (np.arange(len(ink)) + 0.5) * 2 / len(ink) - 1
    across: NDArray[np.float32] = np.interp(np.linspace(-1, 1, 2 * _HALF + 1), places, ink).astype(
        np.float32
    )
    return across


def _around(boxes: list[Box]) -> Box | None:
    if not boxes:
        return None
    rows, columns = ([box[n] for box in boxes] for n in (0, 1))
    return (
        slice(min(s.start for s in rows), max(s.stop for s in rows)),
        slice(min(s.start for s in columns), max(s.stop for s in columns)),
    )


def _inked(layer: Layer) -> Box | None:
    """Where there is anything at all."""
    rows, columns = (np.flatnonzero(layer.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
