"""A stroke: the points of a finger and the smooth curve through them.

Rule: pure. A stroke grows piece by piece, and a piece never changes: the saved picture equals
the live one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from halo_paint.brushes import Array, Brush, Colour, ink, turned, width_mm

SOFTEN_S = 0.05
"""Time constant of the pressure; it smooths transitions within a stroke."""
STEADY_S = 0.12
"""Time constant of the direction; a broad nib makes each tremble visible."""
STEP_MM = 0.4
"""Distance between points of the curve."""
LONGEST_MM = 400.0
"""Longest jump that is drawn with points at `STEP_MM`; a longer one is a sensing error."""


@dataclass(frozen=True, slots=True)
class Knot:
    """A measured point of the finger: mm on the surface, and pressure."""

    x: float
    y: float
    pressure: float
    direction: float
    """Direction of motion, radians, smoothed."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a stroke's curve, ready to draw. Arrays of N points, mm."""

    x: Array
    y: Array
    radius: Array
    direction: Array
    """Radians, along the curve."""
    ink: Array
    """(N, bristles) opacity, 0 to 1; the first strand is at the left of the direction."""


@dataclass(slots=True)
class Stroke:
    """One touch as a painted line."""

    brush: Brush
    colour: Colour
    seed: int
    """Seed of the bristles' ink."""
    knots: list[Knot] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    done: bool = False
    _seen: tuple[float, float] = (0.0, 0.0)
    _time_us: int = 0
    _along_mm: float = 0.0
    _reached: tuple[float, float, float] | None = None

    def add(self, x: float, y: float, pressure: float, time_us: int) -> None:
        """Add a point; the curve grows to half way from the last point."""
        # The mean of two points: jitter from frame to frame cancels out.
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
        """End the stroke: draw the rest of the curve, to the last point."""
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
            # A finger at rest has no direction; a new stroke has no old direction.
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
        """Append a quadratic curve from the stroke's end, with a knot as control point."""
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
    """Join all pieces of a stroke; shared end points appear once."""
    parts = [(piece, slice(1 if number else 0, None)) for number, piece in enumerate(stroke.pieces)]
    names = ("x", "y", "radius", "direction", "ink")
    return Piece(
        *(np.concatenate([getattr(piece, name)[part] for piece, part in parts]) for name in names)
    )


def _middle(a: Knot, b: Knot) -> tuple[float, float, float]:
    return (a.x + b.x) / 2, (a.y + b.y) / 2, (a.pressure + b.pressure) / 2


def _directions(x: Array, y: Array, otherwise: float) -> Array:
    """Directions along the curve; where the curve does not move, `otherwise`."""
    dx, dy = np.gradient(x), np.gradient(y)
    direction: Array = np.where(np.hypot(dx, dy) > 1e-6, np.arctan2(dy, dx), otherwise)
    return direction
