"""From a sensed finger to a published pointer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from halo_service.geometry.surface import Surface
from halo_service.profile import TouchStates
from halo_service.sensing.detector import Detector
from halo_service.sensing.hover import hover_height
from halo_service.sensing.nail import pad_under_nail
from halo_service.sensing.pressure import (
    FORCE_UNKNOWN_G,
    force,
    knows_force,
    touch_force,
    touch_pressure,
)
from halo_service.sensing.settings import SensingSettings
from halo_service.values import (
    Contact,
    Diagnostics,
    Fingertip,
    Pointer,
    Signal,
    Touch,
)

FITTED, FITTED_MS = 4, 200.0
"""Last places for the velocity, and their greatest age (chosen: as few as average out the noise
under a curve; over more dropped frames the path is unknown)."""
REGULARISATION_S2 = 1e-12
"""Added to squares of seconds, so that places with equal times have a velocity too: 0."""
STRIKE_SPANS = 2
"""The strike is read from the last two frames before a contact: a finger falls for 0.1 s, and
faster to the end."""
LEAST_FALL_S = 0.01
"""Accuracy of the contact's time (chosen: a third of a frame)."""
HIDDEN_CONFIDENCE = 0.6
"""Factor for a finger without visible surface next to its tip: its halo is another's, or none."""
EDGE_CONFIDENCE = 0.6
"""Factor for a finger outside the surface, where nothing was calibrated: of six such touches of
tuning users four were right."""
RANGE_HYSTERESIS_MM = 5.0
"""A pointer ends this much farther out than a new one starts, so that none flickers."""
ENTRY_S = 0.1
"""A finger that comes in over the edge is found so much later at most (chosen: three frames)."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a finger was in one frame."""

    time_us: int
    x_mm: float
    y_mm: float
    height_mm: float
    """0 in touch."""
    top_mm: float
    """Of the upper side by its own depth; nan where unmeasured."""


@dataclass(frozen=True, slots=True)
class Motion:
    """How a finger moves, by its last places."""

    places: tuple[Place, ...] = ()
    """Oldest first, at most `FITTED`."""
    velocity_mm_s: tuple[float, float] = (0.0, 0.0)
    """Along the surface, x and y."""

    @property
    def speed_mm_s(self) -> float:
        """Along the surface."""
        return math.hypot(*self.velocity_mm_s)

    def strike_mm_s(self, contact_us: float) -> float:
        """Towards the surface, at a contact that is not among the places yet.

        The mean of three estimates with different errors: the pad's fastest fall (the halo shows it
        late), its fall down to the contact (at a time between two frames), and the fastest fall of
        the upper side (which the halo lifts).
        """
        last = self.places[-STRIKE_SPANS:]
        estimates = (
            _fastest([(each.time_us, each.height_mm) for each in self.places[-3:]]),
            _fall(last, contact_us),
            _fastest([(each.time_us, each.top_mm) for each in self.places[-3:]]),
        )
        finite = [each for each in estimates if math.isfinite(each)]
        return max(sum(finite) / len(finite), 0.0) if finite else 0.0


def follow(before: Motion, now: Pointer, time_us: int) -> Motion:
    """Advance a motion by one frame."""
    top_mm = now.diagnostics.top_mm
    place = Place(time_us, now.x_mm, now.y_mm, now.hover_mm, top_mm)
    places = (*before.places, place)[-FITTED:]
    return Motion(places, _velocity(places))


def came_over_edge(
    motion: Motion, now_mm: tuple[float, float], time_us: int, surface: Surface
) -> bool:
    """Return whether a finger that is at `now_mm` was outside just before its oldest place."""
    if not motion.places:
        return False
    first = motion.places[0]
    back = 1e6 * ENTRY_S / max(time_us - first.time_us, 1)
    x_mm = first.x_mm - back * (now_mm[0] - first.x_mm)
    y_mm = first.y_mm - back * (now_mm[1] - first.y_mm)
    return not (0.0 <= x_mm <= surface.width_mm and 0.0 <= y_mm <= surface.height_mm)


def _velocity(places: Sequence[Place]) -> tuple[float, float]:
    """Return the velocity in the last of some places, mm/s; 0 for a single one.

    From a parabola through them: a line would give that of their middle, two frames ago.
    """
    now_us = places[-1].time_us
    recent = [each for each in places if now_us - each.time_us <= 1000.0 * FITTED_MS]
    if len(recent) < 2:
        return 0.0, 0.0
    times_s = [(each.time_us - now_us) / 1e6 for each in recent]
    powers = np.array([(1.0, t, t * t) if len(recent) == FITTED else (1.0, t) for t in times_s])
    places_mm = np.array([(each.x_mm, each.y_mm) for each in recent])
    # By the normal equations, in a fifth of a general solver's time: this runs every frame.
    normal = powers.T @ powers + REGULARISATION_S2 * np.eye(powers.shape[1])
    x, y = np.linalg.solve(normal, powers.T @ places_mm)[1].tolist()
    return x, y


def _fastest(heights: Sequence[tuple[int, float]]) -> float:
    """Return the fastest fall between two neighbouring (time in us, mm), mm/s; nan if unknown."""
    falls = [(a - b) * 1e6 / (later - before) for (before, a), (later, b) in pairwise(heights)]
    return max((fall for fall in falls if math.isfinite(fall)), default=math.nan)


def _fall(places: Sequence[Place], contact_us: float) -> float:
    """Return the slope of the line through places and a contact, mm/s; nan without a place."""
    times_s = [(each.time_us - contact_us) / 1e6 for each in places] + [0.0]
    if -times_s[0] < LEAST_FALL_S:
        return math.nan
    heights = [each.height_mm for each in places] + [0.0]
    mean_s, mean_mm = sum(times_s) / len(times_s), sum(heights) / len(heights)
    spread = sum((t - mean_s) ** 2 for t in times_s)
    together = sum((t - mean_s) * (h - mean_mm) for t, h in zip(times_s, heights, strict=True))
    return -together / spread


def describe(
    id: int,  # noqa: A002 - the wire's name
    slot: int,
    tip: Fingertip,
    signal: Signal,
    detector: Detector,
    contact: Contact,
    states: TouchStates,
) -> Pointer:
    """Return the pointer without its velocity, which is computed afterwards."""
    touching = contact.touching
    pressure = touch_pressure(signal, states) if touching else 0.0
    deviation_g = touch_force(signal, states)[1] if touching and knows_force(states) else math.nan
    x_mm, y_mm = pad_under_nail(tip.pad_mm, tip.pitch_deg, tip.yaw_deg, states.nail_mm)
    hover_mm, deviation_mm = (0.0, math.nan) if touching else hover_height(signal, tip, states)
    return Pointer(
        id=id,
        slot=slot,
        side=tip.side,
        finger=tip.finger,
        state=Touch.TOUCH if touching else Touch.HOVER,
        x_mm=x_mm,
        y_mm=y_mm,
        hover_mm=hover_mm,
        pressure=pressure,
        force_g=force(pressure, states) if touching else _no_force(states),
        vx_mm_s=0.0,
        vy_mm_s=0.0,
        confidence=tip.confidence
        * (HIDDEN_CONFIDENCE if signal.hidden else 1.0)
        * (detector.probability if touching else 1.0 - detector.probability),
        contacts=contact.count,
        diagnostics=Diagnostics(
            camera_mm=tip.camera_mm,
            tip_px=tip.tip_px,
            halo=signal.raw,
            halo_corrected=signal.corrected,
            level=detector.level,
            top_mm=tip.top_mm,
            pitch_deg=tip.pitch_deg,
            yaw_deg=tip.yaw_deg,
            dent_mm=signal.dent_mm,
            probability=detector.probability,
            height_deviation_mm=deviation_mm,
            force_deviation_g=deviation_g,
        ),
    )


def edge(pointer: Pointer, surface: Surface) -> float:
    """Return the factor for how far out a fingertip is."""
    inside = 0.0 <= pointer.x_mm <= surface.width_mm and 0.0 <= pointer.y_mm <= surface.height_mm
    return 1.0 if inside else EDGE_CONFIDENCE


def within_reach(pointer: Pointer, live: bool, surface: Surface, settings: SensingSettings) -> bool:
    """Return whether a fingertip is near enough to the surface and its edges to be a pointer."""
    slack = RANGE_HYSTERESIS_MM if live else 0.0
    margin = settings.edge_margin_mm + slack
    return (
        pointer.hover_mm <= settings.hover_range_mm + slack
        and -margin <= pointer.x_mm <= surface.width_mm + margin
        and -margin <= pointer.y_mm <= surface.height_mm + margin
    )


def _no_force(states: TouchStates) -> float:
    """Return the force in the air: 0, or unknown if the calibration states no forces."""
    return FORCE_UNKNOWN_G if states.touch.force_g < 0.0 else 0.0
