"""HaloTouch's touch detector and its debounce, to the letter (paper 4.3.6). Pure.

A touch departs from an adaptive baseline while the level rises sharply: a rise is the difference
to the frame before, so a finger's first frame cannot show one. A touch ends when two frames in a
row show none; the paper does this for typing, here it is always so. The paper leaves open: a touch
continues while it stays departed, and the baseline does not move meanwhile.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

DEPARTURE = 0.1
"""Of the level (0 subtle, 1 touch) from its baseline (chosen: of 0.05 to 0.7)."""
RISE = 0.05
"""Of the level from one frame to the next (chosen: 0.05 and 0.15 do the same)."""
BASELINE_MS = 400.0
"""Time constant of the exponential smoothing (chosen: 150 to 1000 do the same)."""
FAST_MM_S = 600.0
"""A finger that moves faster along the surface makes artefacts, not touches (paper 6.2;
chosen: 300 to 1200 do the same)."""


@dataclass(frozen=True, slots=True)
class Detector:
    """One finger's detector between two frames."""

    baseline: float
    level: float
    time_us: int
    touching: bool = False
    releasing: bool = False
    """The last frame showed no touch, and this one may confirm it."""


def detect(before: Detector | None, level: float, speed_mm_s: float, time_us: int) -> Detector:
    """Advance by one frame. `before`: None for a finger that has just been found."""
    if before is None:
        return Detector(level, level, time_us)
    if before.touching:
        touched = level - before.baseline > DEPARTURE
        ended = before.releasing and not touched
        return Detector(
            before.baseline, level, time_us, touching=not ended, releasing=not (touched or ended)
        )
    departed = abs(level - before.baseline) > DEPARTURE
    if departed and level - before.level >= RISE and speed_mm_s < FAST_MM_S:
        return Detector(before.baseline, level, time_us, touching=True)
    share = 1.0 - math.exp((before.time_us - time_us) / (1e3 * BASELINE_MS))
    return Detector(before.baseline + share * (level - before.baseline), level, time_us)
