"""Strokes as pixels.

Rule: pure NumPy. Each stroke has its own layer, in which overlapping parts do not add up, so
that it can cross itself without a seam. Layers of open strokes lie over the paper; a finished
stroke becomes part of the paper. Edges are soft over one pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_client import PictureTransform
from halo_paint.brushes import PAPER, Colour
from halo_paint.stroke import Stroke
from halo_paint.sweep import Box, Layer, around, meet, sweep

Pixels = NDArray[np.uint8]
"""(H, W, 3) red, green, blue."""
MOST_BYTES = 100_000_000
"""Of paper that is stored for undo; older steps draw all strokes again."""


@dataclass(slots=True)
class _Wet:
    """An open stroke."""

    layer: Layer
    drawn: int = 0
    """Number of pieces in the layer."""
    inked: Box | None = None
    """All pixels of the layer that are not 0 are inside."""


@dataclass(frozen=True, slots=True)
class _Before:
    """The paper under a stroke, for undo."""

    stroke: Stroke
    box: Box
    pixels: Pixels


class Canvas:
    """A paper in pixels, and the place of the surface on it."""

    def __init__(
        self, width: int, height: int, placing: PictureTransform, paper: Colour = PAPER
    ) -> None:
        self.placing = placing
        self._dry = np.empty((height, width, 3), np.uint8)
        self._dry[:] = paper
        self.pixels: Pixels = self._dry.copy()
        """The visible picture."""
        self._paper = paper
        self._wet: dict[int, tuple[Stroke, _Wet]] = {}
        self._before: list[_Before] = []
        self._shown: list[int] = []
        """The finished strokes on the paper, by their `id`."""

    def grow(self, stroke: Stroke) -> Box | None:
        """Draw the new pieces of a stroke; return the box that changed, or None."""
        if id(stroke) not in self._wet:
            self._wet[id(stroke)] = stroke, _Wet(self._empty())
        _, wet = self._wet[id(stroke)]
        box = sweep(wet.layer, self.placing, stroke, wet.drawn)
        wet.drawn = len(stroke.pieces)
        if box is not None:
            wet.inked = around([wet.inked, box])
            self._show(box)
        return box

    def dry(self, stroke: Stroke) -> None:
        """Make a finished stroke part of the paper."""
        _, wet = self._wet.pop(id(stroke))
        self._shown.append(id(stroke))
        box = wet.inked
        if box is None:
            return
        self._before.append(_Before(stroke, box, self._dry[box].copy()))
        while sum(each.pixels.nbytes for each in self._before) > MOST_BYTES:
            self._before.pop(0)
        if any(meet(box, other.inked) for _, other in self._wet.values()):
            self._dry[box] = over(self._dry[box], wet.layer[box], stroke.colour)
            self._show(box)
        else:  # The picture shows this stroke over the paper already; a large one takes long.
            self._dry[box] = self.pixels[box]

    def undo(self, strokes: list[Stroke]) -> Box:
        """Show these finished strokes; return the box that changed.

        It is quick where only the last stroke is gone, else all are drawn again.
        """
        last = self._before[-1] if self._before else None
        if last is None or [*map(id, strokes), id(last.stroke)] != self._shown:
            self.repaint(strokes)
            return self._whole
        self._before.pop()
        self._shown.pop()
        self._dry[last.box] = last.pixels
        self._show(last.box)
        return last.box

    def repaint(self, strokes: list[Stroke]) -> None:
        """Draw all finished strokes again; open strokes stay."""
        self._before, self._shown = [], [id(stroke) for stroke in strokes]
        self._dry[:] = self._paper
        for stroke in strokes:
            layer = self._empty()
            box = sweep(layer, self.placing, stroke)
            if box is not None:
                self._dry[box] = over(self._dry[box], layer[box], stroke.colour)
        self._show(self._whole)

    @property
    def _whole(self) -> Box:
        return slice(0, self._dry.shape[0]), slice(0, self._dry.shape[1])

    def _show(self, box: Box) -> None:
        pixels = self._dry[box]
        for stroke, wet in self._wet.values():
            if meet(box, wet.inked):
                pixels = over(pixels, wet.layer[box], stroke.colour)
        self.pixels[box] = pixels

    def _empty(self) -> Layer:
        return np.zeros(self._dry.shape[:2], np.float32)


def over(below: Pixels, layer: Layer, colour: Colour) -> Pixels:
    """Return a picture with a colour over it; `layer` is the opacity."""
    opacity = layer[..., None]
    mixed = below * (1 - opacity) + np.array(colour, np.float32) * opacity
    mixed_pixels: Pixels = np.round(mixed).astype(np.uint8)
    return mixed_pixels
