"""A pointer that draws a circle, so that a connection can be checked without camera and hand.

Rule: pure. A frame follows from its time and the time of the frame before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from halo_service.values import (
    Diagnostics,
    Finger,
    Pointer,
    Side,
    Touch,
    TouchEvent,
    TouchFrame,
)

TURN_S = 4.0
"""Time of one circle."""
TOUCH_S = 3.0
"""The pointer touches so long in each circle, then it hovers."""
RADIUS_SHARE = 0.35
"""Of the smaller side of the surface."""
HIGHEST_MM = 30.0
STRIKE_MM_S = 200.0
FORCE_G = 100.0
"""Force in the middle of a touch, where the pressure is 1."""
LEAST_PRESSURE = 0.02


@dataclass(frozen=True, slots=True)
class Pattern:
    """The circle on one surface, in millimetres."""

    surface: str = "table"
    width_mm: float = 300.0
    height_mm: float = 200.0
    pointer_id: int = 1

    def frame(self, t_s: float, before_s: float, time_us: int) -> TouchFrame:
        """Return the frame at a time.

        `t_s`: since the pattern began; `before_s`: the same of the frame before, negative for the
        first one; `time_us`: the time that the frame states.
        """
        pointer = self._pointer(t_s)
        events = tuple(self._event(kind, at_s, t_s) for kind, at_s in _changes(before_s, t_s))
        return TouchFrame(time_us, self.surface, self.width_mm, self.height_mm, (pointer,), events)

    def _place(self, t_s: float) -> tuple[float, float]:
        """Return x and y: from the far side on, clockwise as the user sees it."""
        turn = 2.0 * math.pi * t_s / TURN_S
        radius_mm = RADIUS_SHARE * min(self.width_mm, self.height_mm)
        return (
            self.width_mm / 2.0 + radius_mm * math.sin(turn),
            self.height_mm / 2.0 - radius_mm * math.cos(turn),
        )

    def _pointer(self, t_s: float) -> Pointer:
        since_s = t_s % TURN_S
        touching = since_s < TOUCH_S
        press = math.sin(math.pi * since_s / TOUCH_S) if touching else 0.0
        rise = math.sin(math.pi * (since_s - TOUCH_S) / (TURN_S - TOUCH_S)) if not touching else 0.0
        x_mm, y_mm = self._place(t_s)
        turn = 2.0 * math.pi * t_s / TURN_S
        speed_mm_s = 2.0 * math.pi / TURN_S * RADIUS_SHARE * min(self.width_mm, self.height_mm)
        pressure = max(press, LEAST_PRESSURE) if touching else 0.0
        return Pointer(
            id=self.pointer_id,
            slot=0,
            side=Side.RIGHT,
            finger=Finger.INDEX,
            state=Touch.TOUCH if touching else Touch.HOVER,
            x_mm=x_mm,
            y_mm=y_mm,
            hover_mm=max(HIGHEST_MM * rise, 0.0),
            pressure=pressure,
            force_g=FORCE_G * pressure,
            vx_mm_s=speed_mm_s * math.cos(turn),
            vy_mm_s=speed_mm_s * math.sin(turn),
            confidence=1.0,
            contacts=math.floor(t_s / TURN_S) + 1,
            diagnostics=_diagnostics(1.0 + 0.5 * pressure if touching else -rise, touching),
        )

    def _event(self, kind: str, at_s: float, t_s: float) -> TouchEvent:
        x_mm, y_mm = self._place(at_s)
        return TouchEvent(
            kind="down" if kind == "down" else "up",
            id=self.pointer_id,
            slot=0,
            x_mm=x_mm,
            y_mm=y_mm,
            strike_mm_s=STRIKE_MM_S if kind == "down" else 0.0,
            ago_ms=1000.0 * (t_s - at_s),
            contacts=math.floor(at_s / TURN_S) + 1,
        )


def _changes(before_s: float, t_s: float) -> list[tuple[str, float]]:
    """Return the downs and ups after one time and until another, oldest first."""
    first, last = math.floor(before_s / TURN_S), math.floor(t_s / TURN_S)
    turns = range(max(first, 0), last + 1)
    every = [
        (kind, turn * TURN_S + at_s)
        for turn in turns
        for kind, at_s in (("down", 0.0), ("up", TOUCH_S))
    ]
    return [(kind, at_s) for kind, at_s in every if before_s < at_s <= t_s]


def _diagnostics(level: float, touching: bool) -> Diagnostics:
    nowhere = (0.0, 0.0, 0.0), (0.0, 0.0)
    probability = 1.0 if touching else 0.0
    return Diagnostics(*nowhere, 0.0, 0.0, level, 0.0, 45.0, 0.0, probability=probability)
