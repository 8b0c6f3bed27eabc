"""Stage 7: the probability that a finger touches, from all that one frame shows of it.

Evidence: the level of its halo, how fast that rises, how suddenly the rise ends, and the finger's
own depth, each over its standard deviation. Their log-odds are added: no one of them decides alone,
none is a veto. What the evidence is worth was measured on virtual tuning users (see
docs/evaluation.md), so the probability is calibrated there: of the frames with 0.9, about 90 %
touch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from halo_service.profile import TouchStates
from halo_service.sensing.hover import own_height
from halo_service.sensing.states import at_calibrated_pitch, span, values_of
from halo_service.values import Finger, Fingertip, Signal

CONTACT_LEVEL = 0.5
"""The pad meets the surface halfway from subtle, 1 mm above it, to a relaxed touch (chosen)."""
LEVEL_ODDS, RISE_ODDS, OWN_ODDS = 1.7, 0.2, 1.0
"""Log-odds for each standard deviation of the level, of its rise in one frame, and of the finger's
own depth (logistic regressions on tuning users, rounded; see docs/evaluation.md). A normal
distribution is worth 1.7; the own depth is worth less, for a fingertip that is found next to its
place reads another depth."""
STOP_ODDS = 0.3
"""Log-odds for each standard deviation by which the level rose faster just before: the surface
stops a finger in one frame, a hovering one stops itself over several (chosen: with the most sigmas
it outweighs a level that reads 0.2 too low)."""
STILL = 2.0
"""A finger stops where it rises or falls by less than half of that (chosen)."""
REST_ODDS, RISEN_MM, RISE_DEVIATION_MM = 0.5, 2.5, 1.5
"""A finger leaves the surface by rising. Its own depth, above the lowest place of the touch, is
evidence of contact below `RISEN_MM` and evidence against it above: log-odds for each standard
deviation (chosen; depth repeats to a millimetre, and a finger rises by 3 mm in one frame)."""
PRIOR_ODDS = 0.9
"""Log-odds where the calibrated finger's level is at contact and nothing else is measured (the
regression gives 0.7; higher, so that a touch whose halo is weaker than the sweep predicts is not
missed)."""
MOST_SIGMAS = 4.0
"""No evidence counts more than this: a misread frame may be off by any number of them (chosen)."""
LEVEL_DEVIATION, VAGUE_DEVIATION = 0.25, 2.0
"""The level differs by the first from frame to frame and from place to place even with steady
readings, and by the second where the calibration does not show what they are worth (chosen)."""
OFFSET_DEVIATION = 0.8
"""Standard deviation of how much higher or lower another finger reads than the calibrated index
finger (measured on virtual open hands: middle fingers up to 1.5 higher, ring fingers 0.5 lower)."""
WAITING_LEVEL, WAITING_DEVIATION = 0.75, 0.4
"""A waiting finger's level above the hover state's, and its standard deviation: people wait at 5 to
15 mm (on virtual open hands it is 0.3; chosen higher, because a weaker halo also rises less)."""
LEAST_HALO = 0.3
"""Of the hover state's: a finger with less is too high to judge (chosen)."""
CROSSTALK = 0.4
"""Share of a neighbour's rise that shows at another finger, and its standard deviation (chosen; on
virtual open hands it is 0 to 0.2, and 0.7 from middle to ring finger at one user of five)."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What one frame shows of whether a finger touches."""

    level: float
    """0 subtle, 1 touch."""
    deviation: float
    """Standard deviation of that."""
    height_mm: float = math.nan
    """By the finger's own depth; nan where it is not measured."""
    height_deviation_mm: float = math.inf
    no_halo: float = -2.5
    """Level of the empty surface."""
    waiting: float = -1.5
    """Level of the hover state."""
    calibrated: bool = True
    """Whether the states were held by this finger."""


def evidence(signal: Signal, tip: Fingertip, states: TouchStates) -> Evidence:
    """Return what a frame shows."""
    scale = span(signal, states.subtle, states.touch)
    deviation = math.hypot(min(scale.deviation, VAGUE_DEVIATION), LEVEL_DEVIATION)
    height_mm, height_deviation_mm = own_height(signal, tip, states)
    calibrated = tip.finger is Finger.INDEX
    if not calibrated:
        height_deviation_mm = math.inf
    return Evidence(
        scale.at(at_calibrated_pitch(signal, states.subtle)),
        deviation,
        height_mm,
        height_deviation_mm,
        scale.at([0.0] * len(values_of(states.subtle))),
        scale.at(values_of(states.hover)),
        calibrated,
    )


def contact_level(seen: Evidence, rest: float, neighbour_rise: float = 0.0) -> tuple[float, float]:
    """Return the level at which a finger meets the surface, and its standard deviation.

    Only the index finger is calibrated. Another one reads higher or lower, which shows while it
    waits above the surface, and its neighbours' halos reach it. `rest`: its level while it waits,
    nan where unknown; `neighbour_rise`: how far a neighbour's level is above its rest.
    """
    if seen.calibrated:
        return CONTACT_LEVEL, 0.0
    offset, deviation = _offset(seen, rest)
    crosstalk = CROSSTALK * neighbour_rise
    return CONTACT_LEVEL + offset + crosstalk, math.hypot(deviation, crosstalk)


def _offset(seen: Evidence, rest: float) -> tuple[float, float]:
    """Return how much higher a finger reads than the calibrated one, and its deviation."""
    usual, halo = seen.waiting - seen.no_halo, rest - seen.no_halo
    if usual <= 0.0 or not halo > LEAST_HALO * usual:  # nan too: nothing is known high above
        return 0.0, OFFSET_DEVIATION
    variance = (WAITING_DEVIATION * max(usual / halo, 1.0)) ** 2
    share = OFFSET_DEVIATION**2 / (OFFSET_DEVIATION**2 + variance)
    return share * (rest - seen.waiting - WAITING_LEVEL), math.sqrt(share * variance)


def contact_probability(
    seen: Evidence,
    rise: float,
    before: float = 0.0,
    lowest_mm: float = math.nan,
    rest: float = math.nan,
    neighbour_rise: float = 0.0,
) -> float:
    """Return the probability that a finger touches.

    `rise`: of the level, in one frame; `before`: how fast it rose in the frames before;
    `lowest_mm`: of its heights in this touch, nan where it does not touch; `rest`,
    `neighbour_rise`: see `contact_level`.
    """
    meets, deviation = contact_level(seen, rest, neighbour_rise)
    deviation = math.hypot(seen.deviation, deviation)
    odds = PRIOR_ODDS if seen.calibrated else 0.0
    odds += LEVEL_ODDS * _sigmas(seen.level - meets, deviation)
    odds += RISE_ODDS * _sigmas(rise, seen.deviation)
    odds += STOP_ODDS * _sigmas(max(before - STILL * abs(rise), 0.0), seen.deviation)
    if math.isfinite(seen.height_mm):
        odds += OWN_ODDS * _sigmas(-seen.height_mm, seen.height_deviation_mm)
    risen_mm = seen.height_mm - lowest_mm
    if math.isfinite(risen_mm):
        odds += REST_ODDS * _sigmas(RISEN_MM - risen_mm, RISE_DEVIATION_MM)
    return 1.0 / (1.0 + math.exp(-odds))


def _sigmas(value: float, deviation: float) -> float:
    """Return a value in standard deviations, bounded; 0 where nothing is known."""
    return min(max(value / deviation, -MOST_SIGMAS), MOST_SIGMAS)
