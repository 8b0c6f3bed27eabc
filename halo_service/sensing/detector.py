"""Stage 7: the touch detector (paper 4.3.6).

A touch is a departure of the level from a slowly adapting baseline while the level rises
sharply, or to a level that no hovering finger reaches; it ends when the level falls. Pure: time is
an argument.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from halo_service.sensing.settings import SensingSettings

RELAXED_LEVEL = 1.0
CONTACT_LEVEL = 0.5
"""The pad meets the surface halfway from subtle, 1 mm above it, to a relaxed touch (chosen)."""


@dataclass(frozen=True, slots=True)
class Detector:
    """One finger's detector between two frames."""

    baseline: float
    """Where the level usually is, smoothed over time while nothing touches."""
    level: float
    """The last frame's level: 0 subtle, 1 touch."""
    time_us: int
    touching: bool = False
    ago_us: int = 0
    """How long before `time_us` the level crossed into the present state, if it just did."""
    was_above: bool = True
    """Whether it was seen above a relaxed touch: one that was found pressing must lift first."""


def detect(
    before: Detector | None,
    level: float,
    time_us: int,
    speed_mm_s: float,
    settings: SensingSettings,
) -> Detector:
    """Advance a detector by one frame.

    `before`: None for a finger that was just found; it does not touch until it comes down.
    """
    if before is None:
        return Detector(level, level, time_us, was_above=level < RELAXED_LEVEL)
    elapsed_us = max(time_us - before.time_us, 1)
    rise = level - before.level
    if before.touching:
        touching = level >= settings.up_level
        crossed = settings.up_level
    else:
        departed = level - before.baseline > settings.down_departure
        near = level > settings.down_level
        still = speed_mm_s < settings.fast_mm_s
        sharp = rise >= settings.down_rise_per_s * elapsed_us / 1e6
        sure = level >= settings.sure_level
        touching = before.was_above and departed and near and still and (sharp or sure)
        crossed = CONTACT_LEVEL
    changed = touching != before.touching
    return Detector(
        baseline=before.baseline if touching else _smoothed(before, level, elapsed_us, settings),
        level=level,
        time_us=time_us,
        touching=touching,
        ago_us=round(elapsed_us * _since(crossed, before.level, level)) if changed else 0,
        was_above=before.was_above or level < RELAXED_LEVEL,
    )


def _smoothed(before: Detector, level: float, elapsed_us: int, settings: SensingSettings) -> float:
    """Follow the level slowly; never rise so far that a clear touch could not depart from it."""
    share = 1.0 - math.exp(-elapsed_us / (1000.0 * settings.baseline_time_ms))
    followed = before.baseline + share * (level - before.baseline)
    highest = max(before.baseline, settings.sure_level - settings.down_departure)
    return min(followed, highest)


def _since(crossed: float, previous: float, level: float) -> float:
    """Return the part of the frame's interval since the level crossed a line; 0 to 1."""
    if level == previous:
        return 0.0
    return min(max((level - crossed) / (level - previous), 0.0), 1.0)
