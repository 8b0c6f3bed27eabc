"""From a sensed finger to what clients are told of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from halo_service.geometry.surface import Surface
from halo_service.profile import TouchStates
from halo_service.sensing.hover import hover_height
from halo_service.sensing.pressure import FORCE_UNKNOWN_G, force, touch_pressure
from halo_service.sensing.settings import SensingSettings
from halo_service.values import (
    Contact,
    Diagnostics,
    Fingertip,
    Pointer,
    Signal,
    Touch,
)

FITTED_MS = 100.0
"""A pointer's velocity is that of a line through its last places (chosen: three frames)."""
FITTED = 4
"""Places kept for it."""
STRIKE_SPANS = 2
"""The fastest of so many last spans between frames is the strike: the very last is cut short by
the contact, and a finger that lands has slowed down since."""
RANGE_HYSTERESIS_MM = 5.0
"""A live pointer may go this much farther than a new one may come in, so that none flickers."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a finger was in one frame."""

    time_us: int
    x_mm: float
    y_mm: float
    height_mm: float
    """0 in touch."""


@dataclass(frozen=True, slots=True)
class Motion:
    """How a finger moves, by its last places."""

    places: tuple[Place, ...] = ()
    """Oldest first, at most `FITTED`."""

    @property
    def velocity_mm_s(self) -> tuple[float, float]:
        """Along the surface, x and y: slopes of lines through the last places."""
        last = self._recent()
        return _slope(last, [each.x_mm for each in last]), _slope(
            last, [each.y_mm for each in last]
        )

    @property
    def speed_mm_s(self) -> float:
        """Along the surface."""
        return math.hypot(*self.velocity_mm_s)

    @property
    def strike_mm_s(self) -> float:
        """Towards the surface, just before a contact that is not among the places yet."""
        spans = list(pairwise(self.places))[-STRIKE_SPANS:]
        falls = ((a.height_mm - b.height_mm) * 1e6 / (b.time_us - a.time_us) for a, b in spans)
        return max(0.0, *falls, 0.0)

    def _recent(self) -> list[Place]:
        since_us = self.places[-1].time_us - 1000.0 * FITTED_MS if self.places else 0.0
        return [each for each in self.places if each.time_us >= since_us]


def follow(before: Motion, now: Pointer, time_us: int) -> Motion:
    """Advance a motion by one frame."""
    place = Place(time_us, now.x_mm, now.y_mm, now.hover_mm)
    return Motion((*before.places, place)[-FITTED:])


def _slope(places: Sequence[Place], values: Sequence[float]) -> float:
    """Return the least squares slope of values over time, 1/s; 0 for fewer than two."""
    count = len(places)
    if count < 2:
        return 0.0
    times = [(each.time_us - places[-1].time_us) / 1e6 for each in places]
    mean_s, mean = sum(times) / count, sum(values) / count
    spread = sum((time - mean_s) ** 2 for time in times)
    together = sum((t - mean_s) * (v - mean) for t, v in zip(times, values, strict=True))
    return together / spread


def describe(
    id: int,  # noqa: A002 - the wire's name
    slot: int,
    tip: Fingertip,
    signal: Signal,
    level: float,
    contact: Contact,
    states: TouchStates,
) -> Pointer:
    """Make a pointer of what was sensed; its velocity is not known yet."""
    pressure = touch_pressure(signal, states) if contact.touching else 0.0
    return Pointer(
        id=id,
        slot=slot,
        side=tip.side,
        finger=tip.finger,
        state=Touch.TOUCH if contact.touching else Touch.HOVER,
        x_mm=tip.pad_mm[0],
        y_mm=tip.pad_mm[1],
        hover_mm=0.0 if contact.touching else hover_height(signal, tip, states),
        pressure=pressure,
        force_g=force(pressure, states) if contact.touching else _no_force(states),
        vx_mm_s=0.0,
        vy_mm_s=0.0,
        confidence=tip.confidence,
        contacts=contact.count,
        diagnostics=Diagnostics(
            camera_mm=tip.camera_mm,
            tip_px=tip.tip_px,
            halo=signal.raw,
            halo_corrected=signal.corrected,
            level=level,
            top_mm=tip.top_mm,
            pitch_deg=tip.pitch_deg,
            yaw_deg=tip.yaw_deg,
        ),
    )


def within_reach(pointer: Pointer, live: bool, surface: Surface, settings: SensingSettings) -> bool:
    """Say whether a fingertip is near enough to the surface and its edges to be a pointer."""
    slack = RANGE_HYSTERESIS_MM if live else 0.0
    margin = settings.edge_margin_mm + slack
    return (
        pointer.hover_mm <= settings.hover_range_mm + slack
        and -margin <= pointer.x_mm <= surface.width_mm + margin
        and -margin <= pointer.y_mm <= surface.height_mm + margin
    )


def _no_force(states: TouchStates) -> float:
    """In the air the force is nothing where forces are known at all."""
    return FORCE_UNKNOWN_G if states.touch.force_g < 0.0 else 0.0
