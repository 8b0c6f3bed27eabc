"""Stage 9: the height of the pad above the surface."""

from __future__ import annotations

import math
from itertools import accumulate

import numpy as np

from halo_service.profile import TouchStates
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
FADED = 0.3
"""Below this share of the hover state's halo, the halo counts less, down to nothing at no halo: it
carries no information there."""
CURVE_MM, TAIL_CURVE_MM = 0.6, 3.0
"""Standard deviation of the curves above: between the held heights, and at the onset (chosen: half
of what halos of different shapes differ by)."""
OWN_MM = 2.5
"""The finger's own depth differs by so much from place to place (chosen)."""
TURNED = 2.0
"""A finger that is turned shows another part of its upper side above the pad: its depth differs by
that, and by as much again because steep and flat pitches are read too near to 45 degrees."""
PLAIN_SEEN_DEG, LEAST_SEEN_DEG = 40.0, 5.0
"""Angles between the finger and the line of sight. Below the first one the camera looks along the
finger, and what it sees behind the tip's end is no longer above the pad."""
LEAST_FALL_MM = 4.0
"""The upper side must fall by as much from hover to subtle: half of the way that a finger goes."""


def hover_height(signal: Signal, tip: Fingertip, states: TouchStates) -> tuple[float, float]:
    """Return the pad's height, at least 0, and its standard deviation, mm; inf where unknown.

    The mean of two estimates, each weighted by its variance: from the halo, on a falling curve
    through the held states; and from the finger's own depth, as it read in these states. Above the
    halo's reach the latter counts alone; there is no jump.
    """
    own_mm, own_deviation_mm = own_height(tip, states)
    if signal.hidden or not states.hover.readings:
        seen = math.isfinite(own_mm)
        return (max(own_mm, 0.0), own_deviation_mm) if seen else (ONSET_MM, math.inf)
    halo_mm, halo_deviation_mm, share = _halo_height(signal, states)
    if math.isnan(own_mm):
        return halo_mm, halo_deviation_mm
    if math.isinf(own_deviation_mm):
        faded_mm = (1.0 - share) * max(own_mm, states.hover.height_mm)
        return share * halo_mm + faded_mm, halo_deviation_mm if share > 0.0 else math.inf
    weight = share / halo_deviation_mm**2
    own_weight = 1.0 / own_deviation_mm**2
    height_mm = (weight * halo_mm + own_weight * own_mm) / (weight + own_weight)
    return max(height_mm, 0.0), (weight + own_weight) ** -0.5


def _halo_height(signal: Signal, states: TouchStates) -> tuple[float, float, float]:
    """Return the pad's height by the halo, its standard deviation, mm, and how much it counts."""
    rising = span(signal, states.hover, states.subtle)
    nothing = rising.at([0.0] * len(signal.readings))
    halo = rising.at(signal.readings) - nothing
    levels, heights = curve(states, rising, nothing)
    height_mm = float(np.interp(halo, levels, heights))
    off = min(rising.deviation, 1.0)
    above, below = np.interp((halo - off, halo + off), levels, heights)
    hover_mm = states.hover.height_mm
    tail = min(max(height_mm - hover_mm, 0.0) / max(ONSET_MM - hover_mm, 1.0), 1.0)
    curve_mm = CURVE_MM + (TAIL_CURVE_MM - CURVE_MM) * tail
    faded = FADED * -nothing
    share = min(max(halo / faded, 0.0), 1.0) if faded > 0.0 else float(halo > 0.0)
    return height_mm, math.hypot(float(above - below) / 2.0, curve_mm), share


def own_height(tip: Fingertip, states: TouchStates) -> tuple[float, float]:
    """Return the pad's height by the finger's own depth, and its standard deviation, mm.

    That is inf where the held states do not say how a finger's depth reads.
    """
    hover, subtle = states.hover, states.subtle
    fallen_mm = (
        None if hover.top_mm is None or subtle.top_mm is None else hover.top_mm - subtle.top_mm
    )
    if fallen_mm is None or fallen_mm < LEAST_FALL_MM:
        return tip.top_mm - states.finger_thickness_mm, math.inf
    assert hover.top_mm is not None
    above_mm = tip.top_mm - hover.top_mm
    way_mm = hover.height_mm - subtle.height_mm
    height_mm = hover.height_mm + (above_mm if above_mm > 0.0 else above_mm * way_mm / fallen_mm)
    turned = math.tan(math.radians(tip.pitch_deg)) - math.tan(math.radians(hover.pitch_deg))
    noise_mm = math.hypot(hover.top_noise_mm, subtle.top_noise_mm) / math.sqrt(2.0)
    seen = math.radians(min(max(tip.seen_deg, LEAST_SEEN_DEG), PLAIN_SEEN_DEG))
    hidden = 1.0 / math.tan(seen) - 1.0 / math.tan(math.radians(PLAIN_SEEN_DEG))
    turned_mm, hidden_mm = (TURNED * states.tip_radius_mm * each for each in (turned, hidden))
    return height_mm, math.hypot(noise_mm, OWN_MM, turned_mm, hidden_mm)


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
