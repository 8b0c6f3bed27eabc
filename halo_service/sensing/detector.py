"""Stage 7: the touch detector: from probabilities of contact to touches.

A touch begins when the probability passes one level and ends when it falls below another
(hysteresis). Single frames are misread, so an end must be confirmed by the next frame (`debounce`):
one that is below the geometric mean of both levels. Pure: time is an argument.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from halo_service.sensing.contact import Evidence, contact_level, contact_probability
from halo_service.sensing.settings import SensingSettings

FRAME_US = 33_333
"""A rise is counted for one frame at 30 a second, whatever the camera's rate."""
FADES = 0.8
"""What is left of an earlier rise after each frame (chosen: a third after five)."""
RESTS = 0.1
"""Of a new level in the level at rest (chosen: a third of a second)."""
GAP_FRAMES = 4.0
"""Over a longer gap the rise is unknown."""


@dataclass(frozen=True, slots=True)
class Detector:
    """One finger's detector between two frames."""

    probability: float
    """That it touches, in the last frame."""
    level: float
    """The last frame's level: 0 subtle, 1 touch."""
    time_us: int
    touching: bool = False
    ago_us: int = 0
    """How long before `time_us` the finger met or left the surface, if it just did."""
    rose: float = 0.0
    """How fast the level rose lately, in one frame: the most, fading."""
    lowest_mm: float = math.nan
    """The lowest height by its own depth in this touch; nan after it."""
    rest: float = math.nan
    """The smoothed level while it does not touch."""
    ending: bool = False
    """Whether its touch ended in the last frame; the next one confirms that or not."""
    was_apart: bool = True
    """Whether it was ever seen apart from the surface, or came in over its edge. One that was found
    pressing in the middle must lift first, because it is unknown when it came down."""


def detect(
    before: Detector | None,
    seen: Evidence,
    time_us: int,
    speed_mm_s: float,
    settings: SensingSettings,
    came_in: bool = False,
    neighbour_rise: float = 0.0,
) -> Detector:
    """Advance a detector by one frame.

    `before`: None for a finger that was just found; it does not touch until it comes down, or
    `came_in`: it slides in over the surface's edge, maybe from another camera's surface;
    `neighbour_rise`: how far a neighbour's level is above its rest.
    """
    if before is None:
        probability = contact_probability(seen, 0.0)
        apart = probability < settings.down_level
        return Detector(probability, seen.level, time_us, rest=seen.level, was_apart=apart)
    frames = max(time_us - before.time_us, 1) / FRAME_US
    rise = (seen.level - before.level) / frames if frames < GAP_FRAMES else 0.0
    rose = before.rose * FADES**frames
    meets, _ = contact_level(seen, before.rest, neighbour_rise)
    probability = contact_probability(
        seen, rise, rose, before.lowest_mm, before.rest, neighbour_rise
    )
    apart = before.was_apart or came_in or probability < settings.down_level
    if before.touching:
        touching = probability >= settings.up_level
    else:
        still = speed_mm_s < settings.fast_mm_s
        enough = settings.down_level
        if before.ending:
            enough = math.sqrt(settings.up_level * settings.down_level)
        touching = (before.was_apart or came_in) and still and probability >= enough
    ending = before.touching and not touching
    changed = touching != before.touching
    return Detector(
        probability=probability,
        level=seen.level,
        time_us=time_us,
        touching=touching,
        ago_us=round((time_us - before.time_us) * _since(before.level, seen.level, meets))
        if changed
        else 0,
        rose=max(rise, rose + min(rise, 0.0)),
        rest=before.rest if touching else before.rest + RESTS * (seen.level - before.rest),
        lowest_mm=_lowest_mm(before.lowest_mm, seen.height_mm) if touching or ending else math.nan,
        ending=ending,
        was_apart=apart,
    )


def _lowest_mm(before_mm: float, height_mm: float) -> float:
    known = [each for each in (before_mm, height_mm) if math.isfinite(each)]
    return min(known, default=math.nan)


def _since(previous: float, level: float, meets: float) -> float:
    """Return the part of the frame's interval since the level was at contact; 0 to 1."""
    if level == previous:
        return 0.0
    return min(max((level - meets) / (level - previous), 0.0), 1.0)
