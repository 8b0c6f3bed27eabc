"""The drummer's picture: pads that light up, and the height of the other hand.

Rule: draws on any pygame surface; reads no clock. Pads are drawn once for each size, and again
while they glow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import pygame

from halo_client import PictureTransform
from halo_client.files import appearing
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_drums.kit import Pad
from halo_drums.player import Gesture, Hit, Shape
from halo_window import Placed, Repaint

BACKGROUND = (14, 14, 18)
GLOW_S = 0.45
"""How long a pad glows after a hit."""
RING_S = 0.6
LOW, HIGH = pygame.Color(70, 110, 255), pygame.Color(255, 235, 150)
"""Colour of the bar: deep or sharp."""


@dataclass(slots=True)
class View:
    """State of the picture."""

    kit: tuple[Pad, ...]
    _hits: list[tuple[float, Hit]] = field(default_factory=list)
    _height: float | None = None
    _board: pygame.Surface | None = None
    _drawn_for: object = None
    _repaint: Repaint = field(default_factory=Repaint)

    def update(self, gesture: Gesture, now_s: float) -> None:
        """Take in a gesture at a time."""
        if isinstance(gesture, Hit):
            self._hits.append((now_s, gesture))
        elif isinstance(gesture, Shape):
            self._height = gesture.height

    def draw(self, screen: pygame.Surface, placed: Placed, now_s: float, note: str = "") -> None:
        """Draw what changed; `note` is a line of text at the lower edge."""
        self._hits = [(at_s, hit) for at_s, hit in self._hits if now_s - at_s < RING_S]
        screen_size = screen.get_size()
        if self._board is None or self._drawn_for != (screen_size, placed):
            self._board, self._drawn_for = self._dark(screen, placed), (screen_size, placed)
            self._repaint.changed()
        self._repaint.restore(screen, self._board)
        for pad in self.kit:
            glow = self._glow(pad, now_s)
            if glow > 0.0:
                self._repaint.over(self._pad(screen, placed, pad, glow))
        for at_s, hit in self._hits:
            self._repaint.over(self._ring(screen, placed, hit, (now_s - at_s) / RING_S))
        if self._height is not None:
            self._repaint.over(self._hand(screen, self._height))
        if note:
            words = _font(max(18, screen.get_height() // 24)).render(note, True, (200, 200, 200))
            place = (12, screen.get_height() - words.get_height() - 8)
            self._repaint.over(screen.blit(words, place))

    @property
    def parts(self) -> list[pygame.Rect]:
        """The parts of the screen that differ from the last picture."""
        return self._repaint.parts

    def _dark(self, screen: pygame.Surface, placed: Placed) -> pygame.Surface:
        board = pygame.Surface(screen.get_size(), 0, screen)
        board.fill(BACKGROUND)
        for pad in self.kit:
            self._pad(board, placed, pad, 0.0)
        return board

    def _glow(self, pad: Pad, now_s: float) -> float:
        return max(
            (
                hit.level * max(0.0, 1 - (now_s - at_s) / GLOW_S)
                for at_s, hit in self._hits
                if hit.pad.name == pad.name
            ),
            default=0.0,
        )

    def _pad(self, screen: pygame.Surface, placed: Placed, pad: Pad, glow: float) -> pygame.Rect:
        left, far, right, near = pad.area
        gap = 0.008
        inset = ((left + gap, far + gap), (right - gap, far + gap),
                 (right - gap, near - gap), (left + gap, near - gap))  # fmt: skip
        corners = [self._pixel(placed, u, v) for u, v in inset]
        light = 0.2 + 0.8 * glow
        area = pygame.draw.polygon(screen, [round(light * part) for part in pad.colour], corners)
        edge = pygame.draw.aalines(screen, pad.colour, True, corners)
        font = _font(max(18, screen.get_height() // 24))
        words = font.render(pad.name, True, (0, 0, 0) if glow > 0.5 else (235, 235, 235))
        centre = self._pixel(placed, (left + right) / 2, (far + near) / 2)
        return area.unionall([edge, screen.blit(words, words.get_rect(center=centre))])

    def _ring(self, screen: pygame.Surface, placed: Placed, hit: Hit, age: float) -> pygame.Rect:
        x, y = self._pixel(placed, hit.u, hit.v)
        scale = placed.placing.scale(hit.u * placed.width_mm, hit.v * placed.height_mm)
        radius = scale * (4.0 + 22.0 * hit.level * age)
        light = [round(255 * (1 - age) + part * age) for part in hit.pad.colour]
        width = max(1, round(scale * 1.5 * (1 - age)))
        return pygame.draw.aacircle(screen, light, (x, y), radius, width)

    def _hand(self, screen: pygame.Surface, height: float) -> pygame.Rect:
        """Draw a bar at the left edge: its height and colour show the hand's height."""
        width, tall = max(6, screen.get_width() // 90), screen.get_height()
        length = max(4, round(height * tall))
        colour = LOW.lerp(HIGH, height)
        return pygame.draw.rect(screen, colour, (0, tall - length, width, length))

    @staticmethod
    def _pixel(placed: Placed, u: float, v: float) -> tuple[float, float]:
        return placed.placing.pixel(u * placed.width_mm, v * placed.height_mm)


@lru_cache(maxsize=4)
def _font(height_px: int) -> pygame.font.Font:
    """Load the font once, not for each picture."""
    return pygame.font.Font(None, height_px)


def write_picture(path: Path, kit: tuple[Pad, ...], gestures: Sequence[Gesture]) -> None:
    """Write a PNG of the moment after the loudest hit. Raises `OSError`."""
    hits = [gesture for gesture in gestures if isinstance(gesture, Hit)]
    moment_us = max(hits, key=lambda hit: hit.level).time_us + 90_000 if hits else 0
    view = View(kit)
    for gesture in gestures:
        if gesture.time_us <= moment_us:
            view.update(gesture, gesture.time_us / 1e6)
    pygame.font.init()
    screen = pygame.Surface((1200, 800))
    placing = PictureTransform.fitted(*screen.get_size(), WIDTH_MM, HEIGHT_MM, margin=24.0)
    view.draw(screen, Placed(placing, WIDTH_MM, HEIGHT_MM), moment_us / 1e6)
    with appearing(path) as file:
        pygame.image.save(screen, file, "x.png")
