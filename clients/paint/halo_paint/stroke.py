"""A stroke: what a finger did, and the smooth curve that it means.

Rule: pure. A stroke grows a piece at a time, and a piece never changes once it is there: what
is painted live is what is saved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from halo_paint.brushes import Array, Brush, Colour, ink, turned, width_mm

SOFTEN_S = 0.05
"""Pressure follows the finger so fast; transitions inside a stroke are smooth."""
STEADY_S = 0.12
"""Likewise the direction, for the eye sees each tremble of a broad nib."""
STEP_MM = 0.4
"""Distance of the curve's points."""
LONGEST_MM = 400.0
"""A jump from end to end of any table; a wilder one is a mistake of the sensing, and cut."""


@dataclass(frozen=True, slots=True)
class Knot:
    """Where a finger was seen, mm on the surface, and how hard it pressed."""

    x: float
    y: float
    pressure: float
    direction: float
    """Of its way, radians, smoothed."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a stroke's curve, ready to be drawn. Arrays of N points, mm."""

    x: Array
    y: Array
    radius: Array
    direction: Array
    """Radians, along the curve."""
    ink: Array
    """(N, bristles) opacity, 0 to 1; the first strand is at the left of the direction."""


@dataclass(slots=True)
class Stroke:
    """One touch, painted."""

    brush: Brush
    colour: Colour
    seed: int
    """Of the strands' ink."""
    knots: list[Knot] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    done: bool = False
    _seen: tuple[float, float] = (0.0, 0.0)
    _time_us: int = 0
    _along_mm: float = 0.0
    _reached: tuple[float, float, float] | None = None

    def add(self, x: float, y: float, pressure: float, time_us: int) -> None:
        """The finger was seen here; grows the curve to half way from the last place."""
        # Half way from the place before: what trembles from frame to frame cancels out.
        before = self._seen if self.knots else (x, y)
        self._seen = (x, y)
        x, y = (x + before[0]) / 2, (y + before[1]) / 2
        self._knot(x, y, pressure, time_us)
        if len(self.knots) == 1:
            self._reached = (x, y, self.knots[0].pressure)
        else:
            last, now = self.knots[-2:]
            self._curve_to(last, _middle(last, now))

    def end(self) -> None:
        """The finger left; draws the rest of the way to where it was last."""
        if not self.done and self.knots:
            last = self.knots[-1]
            self._curve_to(last, (*self._seen, last.pressure))
        self.done = True

    def _knot(self, x: float, y: float, pressure: float, time_us: int) -> None:
        if not self.knots:
            self.knots.append(Knot(x, y, pressure, 0.0))
        else:
            last = self.knots[-1]
            passed_s = max(0, time_us - self._time_us) / 1e6
            share, steady = (1 - math.exp(-passed_s / each) for each in (SOFTEN_S, STEADY_S))
            way = (x - last.x, y - last.y)
            turn = math.remainder(math.atan2(way[1], way[0]) - last.direction, 2 * math.pi)
            # Who stands still has no direction, and who has just begun has no old one.
            share_turn = min(1.0, math.hypot(*way) / 2.0) * (
                1.0 if len(self.knots) == 1 else steady
            )
            self.knots.append(
                Knot(
                    x,
                    y,
                    last.pressure + share * (pressure - last.pressure),
                    last.direction + share_turn * turn,
                )
            )
        self._time_us = time_us

    def _curve_to(self, bend: Knot, end: tuple[float, float, float]) -> None:
        """A quadratic curve from where the stroke has come to, bent towards a knot."""
        begin = self._reached
        assert begin is not None  # add() set it with the first knot
        length = math.dist(begin[:2], (bend.x, bend.y)) + math.dist((bend.x, bend.y), end[:2])
        count = 1 + max(1, math.ceil(min(length, LONGEST_MM) / STEP_MM))
        t = np.linspace(0.0, 1.0, count)
        x, y, pressure = (
            (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t**2 * c
            for a, b, c in zip(begin, (bend.x, bend.y, bend.pressure), end, strict=True)
        )
        steps = np.hypot(np.diff(x), np.diff(y))
        along = self._along_mm + np.concatenate([[0.0], np.cumsum(steps)])
        direction = _directions(x, y, bend.direction)
        before = self.knots[-2].direction if len(self.knots) > 1 else bend.direction
        nib = before + t * math.remainder(bend.direction - before, 2 * math.pi)
        width = turned(self.brush, width_mm(self.brush, pressure), nib)
        strands = ink(self.brush, pressure, along, self.seed)
        self.pieces.append(Piece(x, y, width / 2, direction, strands))
        self._along_mm, self._reached = float(along[-1]), end


def whole(stroke: Stroke) -> Piece:
    """All pieces of a stroke as one; points that neighbours share come once."""
    parts = [(piece, slice(1 if number else 0, None)) for number, piece in enumerate(stroke.pieces)]
    names = ("x", "y", "radius", "direction", "ink")
    return Piece(
        *(np.concatenate([getattr(piece, name)[part] for piece, part in parts]) for name in names)
    )


def _middle(a: Knot, b: Knot) -> tuple[float, float, float]:
    return (a.x + b.x) / 2, (a.y + b.y) / 2, (a.pressure + b.pressure) / 2


def _directions(x: Array, y: Array, otherwise: float) -> Array:
    """Along the curve; where it stands still, the direction that it had."""
    dx, dy = np.gradient(x), np.gradient(y)
    direction: Array = np.where(np.hypot(dx, dy) > 1e-6, np.arctan2(dy, dx), otherwise)
    return direction
