"""Stage 9: the height of the pad above the surface."""

from __future__ import annotations

import math
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from halo_service.profile import TouchStates
from halo_service.sensing.fingertips import OBLIQUE_MM, oblique, plain_top_mm
from halo_service.sensing.states import Span, span, values_of
from halo_service.values import Fingertip, Signal

ONSET_MM = 21.0
"""Where the halo begins (paper 4.1.3: at about 20 mm)."""
SHAPE = (
    # height as a share of the way from subtle to hover, halo as a share of the same way back
    (0.44, 0.62),
    (0.67, 0.38),
)
"""The middle of what a halo can do between two held heights: the straight line between them, an
exponential and a sigmoid differ there by up to a millimetre to both sides. Chosen, not fitted."""
TAIL = (
    # share of the way from hover up to the onset, halo as a share of the hover state's
    (0.2, 0.75),
    (0.45, 0.47),
    (0.9, 0.06),
)
"""The same above the hover state."""
CURVE_MM, TAIL_CURVE_MM = 0.6, 3.0
"""Standard deviation of the curves above: between the held heights, and at the onset (chosen: half
of what halos of different shapes differ by)."""
UNHELD_MM = 6.0
"""The finger's own depth differs by so much from its thickness in the hover state (chosen; only
where the held states do not say how it reads near the surface)."""
MISREAD_ODDS = math.log(1e-4)
"""Log-likelihood of an own depth that is far off, over that of one that is exact: another hand may
pass above the finger (chosen)."""
HEIGHTS = 161
"""So many heights are weighed, from 0 to the highest one that the finger can have."""
OWN_MM = 0.7
"""The finger's own depth differs by so much from one posture of the hand to the next (chosen)."""
OBLIQUE_DEVIATION_MM, ANGLE_DEG, UNREAD_ANGLE_DEG = 4.0, 3.0, 15.0
"""Standard deviations of `OBLIQUE_MM`, for fingers differ in their ends and nails (measured on
virtual users), and of the angle to the line of sight: measured, and where no pitch could be read
(chosen)."""
LEAST_FALL_MM = 4.0
"""The upper side must fall by as much from hover to subtle: half of the way that a finger goes."""


def hover_height(signal: Signal, tip: Fingertip, states: TouchStates) -> tuple[float, float]:
    """Return the pad's height, at least 0, and its standard deviation, mm; inf where unknown.

    The mean over all heights, each weighted by how well it agrees with two measurements: the halo,
    by a falling curve through the held states, and the finger's own depth, as it read in these
    states. A halo that hardly changes over some heights says little about them, so above its reach
    the finger's own depth counts alone.
    """
    own_mm, own_deviation_mm = own_height(signal, tip, states)
    rising = span(signal, states.hover, states.subtle)
    if signal.hidden or not states.hover.readings or math.isinf(rising.deviation):
        seen = math.isfinite(own_mm)
        return (max(own_mm, 0.0), own_deviation_mm) if seen else (ONSET_MM, math.inf)
    highest_mm = max(ONSET_MM, states.hover.height_mm + 1.0)  # as in `curve`
    if math.isfinite(own_mm):
        own_deviation_mm = UNHELD_MM if math.isinf(own_deviation_mm) else own_deviation_mm
        highest_mm = max(highest_mm, own_mm + 4.0 * min(own_deviation_mm, UNHELD_MM))
    heights_mm = np.linspace(0.0, highest_mm, HEIGHTS)
    odds = _halo_odds(signal, states, rising, heights_mm)
    if math.isfinite(own_mm):
        off = (heights_mm - own_mm) / own_deviation_mm
        odds += np.logaddexp(-0.5 * off**2, MISREAD_ODDS)
    weights = np.exp(odds - odds.max())
    weights /= weights.sum()
    mean_mm = float(weights @ heights_mm)
    return mean_mm, math.sqrt(float(weights @ (heights_mm - mean_mm) ** 2))


def _halo_odds(
    signal: Signal, states: TouchStates, rising: Span, heights_mm: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the log-likelihood of the halo at heights, up to a constant."""
    nothing = rising.at([0.0] * len(signal.readings))
    levels, held_mm = curve(states, rising, nothing)
    expected = np.interp(heights_mm, held_mm[::-1], levels[::-1])
    hover_mm = states.hover.height_mm
    tail = np.clip((heights_mm - hover_mm) / max(ONSET_MM - hover_mm, 1.0), 0.0, 1.0)
    curve_mm = CURVE_MM + (TAIL_CURVE_MM - CURVE_MM) * tail
    variance = rising.deviation**2 + (np.gradient(expected, heights_mm) * curve_mm) ** 2
    halo = min(max(rising.at(signal.readings) - nothing, levels[0]), levels[-1])
    off = halo - expected
    return np.asarray(-0.5 * (off**2 / variance + np.log(variance)))


def own_height(signal: Signal, tip: Fingertip, states: TouchStates) -> tuple[float, float]:
    """Return the pad's height by the finger's own depth, and its standard deviation, mm.

    That is inf where the held states do not say how a finger's depth reads.
    """
    hover, subtle = states.hover, states.subtle
    if hover.top_mm is None or subtle.top_mm is None:
        return tip.top_mm - states.finger_thickness_mm, math.inf
    hover_deg, subtle_deg = (
        45.0 if state.seen_deg is None else state.seen_deg for state in (hover, subtle)
    )
    held_mm = plain_top_mm(hover.top_mm, hover_deg)
    fallen_mm = held_mm - plain_top_mm(subtle.top_mm, subtle_deg)
    if fallen_mm < LEAST_FALL_MM:
        return tip.top_mm - states.finger_thickness_mm, math.inf
    above_mm = signal.top_mm - held_mm
    way_mm = hover.height_mm - subtle.height_mm
    height_mm = hover.height_mm + (above_mm if above_mm > 0.0 else above_mm * way_mm / fallen_mm)
    noise_mm = math.hypot(hover.top_noise_mm, subtle.top_noise_mm) / math.sqrt(2.0)
    turned = oblique(tip.seen_deg) - oblique(hover_deg)
    angle_deg = UNREAD_ANGLE_DEG if math.isnan(tip.seen_deg) else ANGLE_DEG
    per_deg = OBLIQUE_MM * math.radians(1.0) * (1.0 + oblique(tip.seen_deg) ** 2)
    return height_mm, math.hypot(
        noise_mm,
        OWN_MM,
        signal.top_deviation_mm,
        OBLIQUE_DEVIATION_MM * turned,
        angle_deg * per_deg,
    )


def curve(
    states: TouchStates, rising: Span, nothing: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return halos on a scale above nothing, rising, and the heights at which they are seen, mm."""
    hover, subtle, touch = states.hover, states.subtle, states.touch
    up_mm = max(ONSET_MM - hover.height_mm, 1.0)
    way_mm = hover.height_mm - subtle.height_mm
    at_hover, at_subtle, at_touch = -nothing, 1.0 - nothing, rising.at(values_of(touch)) - nothing
    points = [(0.0, hover.height_mm + up_mm)]
    points += [(d * at_hover, hover.height_mm + h * up_mm) for h, d in reversed(TAIL)]
    points.append((at_hover, hover.height_mm))
    points += [(at_hover + d, subtle.height_mm + h * way_mm) for h, d in reversed(SHAPE)]
    points += [(at_subtle, subtle.height_mm), (at_touch, touch.height_mm)]
    levels, heights = zip(*points, strict=True)
    return tuple(accumulate(levels, max)), heights
