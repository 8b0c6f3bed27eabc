"""The painter's picture: the paper, the palette at its edges, and hovering fingers.

Rule: draws on any pygame surface; reads no clock. Only changed parts of the paper are copied.
"""

from __future__ import annotations

import numpy as np
import pygame

from halo_client import PictureTransform
from halo_paint.brushes import COLOURS, PAPER, Brush, Colour
from halo_paint.canvas import Canvas, over
from halo_paint.painter import Change, News, Painter
from halo_paint.palette import CELLS, Action, Cell
from halo_paint.stroke import Stroke
from halo_paint.sweep import Box, Layer, sweep
from halo_protocol import Pointer
from halo_window import Placed, Repaint

PALETTE = (236, 231, 220)
INK = (60, 58, 66)
NEAR_MM = 25.0
"""Below this height, a ring shows where the finger would paint."""


class View:
    """A canvas of the screen's size, and its copy as a pygame surface."""

    def __init__(self, size: tuple[int, int], placed: Placed) -> None:
        self.size, self.placed = size, placed
        self.canvas = Canvas(*size, placed.placing)
        # The depth of a display, so that copying converts nothing.
        self._sheet = pygame.Surface(size, depth=32)
        self._sheet.fill(PAPER)
        self._repaint = Repaint()
        self._scratch = pygame.Surface(size, pygame.SRCALPHA)
        self._samples: dict[str, tuple[Box, Layer] | None] = {}
        self._font = pygame.font.Font(None, max(16, size[1] // 42))
        self._strips: list[tuple[pygame.Surface, pygame.Rect]] = []
        self._chosen: tuple[Brush, Colour] | None = None

    def update(self, news: list[News], painter: Painter) -> None:
        """Apply changes to the paper."""
        for change, stroke in news:
            if change is Change.GREW and stroke is not None:
                self._copy(self.canvas.grow(stroke))
            elif change is Change.ENDED and stroke is not None:
                self.canvas.dry(stroke)
            elif change in (Change.UNDONE, Change.CLEARED):
                self._copy(self.canvas.undo(painter.strokes))

    def draw(
        self, screen: pygame.Surface, painter: Painter, fingers: tuple[Pointer, ...], note: str
    ) -> None:
        """Draw what changed; `note` is a line of text at the lower edge."""
        if self._chosen != (painter.brush, painter.colour):
            self._chosen = painter.brush, painter.colour
            before = [place for _, place in self._strips]
            self._strips = [self._strip(left, painter) for left in (True, False)]
            for place in (*before, *(place for _, place in self._strips)):
                self._repaint.changed(place)
        for part in self._repaint.restore(screen, self._sheet):
            screen.set_clip(part)
            for strip, place in self._strips:
                if place.colliderect(part):
                    screen.blit(strip, place)
        screen.set_clip(None)
        for finger in fingers:
            if not finger.touching and finger.hover_mm < NEAR_MM:
                self._ring(screen, painter, finger)
        if note:
            words = self._font.render(note, True, INK)
            place = words.get_rect(midbottom=(self.size[0] / 2, self.size[1] - 8))
            self._repaint.over(screen.blit(words, place))

    @property
    def parts(self) -> list[pygame.Rect]:
        """The parts of the screen that differ from the last picture."""
        return self._repaint.parts

    def _copy(self, box: Box | None) -> None:
        if box is not None:
            pixels = pygame.surfarray.pixels3d(self._sheet)
            pixels[box[1], box[0]] = self.canvas.pixels[box].swapaxes(0, 1)
            del pixels  # The array locks the surface.
            rows, columns = box
            size = columns.stop - columns.start, rows.stop - rows.start
            self._repaint.changed(pygame.Rect((columns.start, rows.start), size))

    def _strip(self, left: bool, painter: Painter) -> tuple[pygame.Surface, pygame.Rect]:
        """Draw one side of the palette; return it and its place."""
        sheet = self._scratch
        drawn: list[pygame.Rect] = []
        for cell in CELLS:
            if (cell.area[0] < 0.5) == left:
                chosen = cell.means in (painter.brush, painter.colour)
                drawn += self._cell(sheet, cell, painter, chosen)
        place = drawn[0].unionall(drawn[1:]).inflate(2, 2).clip(sheet.get_rect())
        strip = sheet.subsurface(place).copy()
        sheet.fill((0, 0, 0, 0), place)
        return strip, place

    def _cell(
        self, screen: pygame.Surface, cell: Cell, painter: Painter, chosen: bool
    ) -> list[pygame.Rect]:
        """Draw one button; return the parts that were drawn on."""
        left, far, right, near = cell.area
        corners = [
            self._pixel(u, v) for u, v in ((left, far), (right, far), (right, near), (left, near))
        ]
        drawn = [pygame.draw.polygon(screen, PALETTE, corners)]
        middle = (left + right) / 2, (far + near) / 2
        centre, scale = self._pixel(*middle), self._scale(*middle)
        if isinstance(cell.means, Brush):
            drawn += self._sample(screen, cell.means, painter, *middle)
        elif isinstance(cell.means, Action):
            words = self._font.render(cell.means.value, True, INK)
            drawn.append(screen.blit(words, words.get_rect(center=centre)))
        else:
            drawn.append(pygame.draw.aacircle(screen, cell.means, centre, 7.0 * scale))
        if chosen:
            width = max(1, round(0.7 * scale))
            drawn.append(pygame.draw.aacircle(screen, INK, centre, 9.0 * scale, width))
        return drawn

    def _sample(
        self, screen: pygame.Surface, brush: Brush, painter: Painter, u: float, v: float
    ) -> list[pygame.Rect]:
        """Draw a short stroke of the brush, from light to strong."""
        if brush.name not in self._samples:
            self._samples[brush.name] = self._sample_layer(brush, u, v)
        sample = self._samples[brush.name]
        if sample is None:
            return []
        box, layer = sample
        below = np.full((*layer.shape, 3), PALETTE, np.uint8)
        pixels = over(below, layer, painter.colour).swapaxes(0, 1)
        return [screen.blit(pygame.surfarray.make_surface(pixels), (box[1].start, box[0].start))]

    def _sample_layer(self, brush: Brush, u: float, v: float) -> tuple[Box, Layer] | None:
        """Opacity of a sample, and its place."""
        x, y = u * self.placed.width_mm, v * self.placed.height_mm
        stroke = Stroke(brush, COLOURS[0], seed=1)
        fall_mm = -6.0 if brush.nib_deg is None else 6.0  # Across the nib, not along it.
        for step, part in enumerate(np.linspace(-1.0, 1.0, 9)):
            place = (x + 3.5 * part, y + fall_mm * part + 2.0 * part**2)
            stroke.add(*place, 0.55 + 0.4 * part, step * 50_000)
        stroke.end()
        layer = np.zeros(self.size[::-1], np.float32)
        box = sweep(layer, self.placed.placing, stroke)
        return None if box is None else (box, layer[box].copy())

    def _ring(self, screen: pygame.Surface, painter: Painter, finger: Pointer) -> None:
        scale = self._scale(finger.u, finger.v)
        radius = (2.0 + 0.5 * finger.hover_mm) * scale
        at = self._pixel(finger.u, finger.v)
        self._repaint.over(pygame.draw.aacircle(screen, painter.colour, at, radius, 2))

    def _pixel(self, u: float, v: float) -> tuple[float, float]:
        return self.placed.placing.pixel(u * self.placed.width_mm, v * self.placed.height_mm)

    def _scale(self, u: float, v: float) -> float:
        placing: PictureTransform = self.placed.placing
        return placing.scale(u * self.placed.width_mm, v * self.placed.height_mm)
