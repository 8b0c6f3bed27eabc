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
"""Below this share of the hover state's halo the finger's own depth is blended in, up to all of it
at no halo: coarser, but the halo carries no information there."""


def hover_height(signal: Signal, tip: Fingertip, states: TouchStates) -> float:
    """Return the pad's height, mm, at least 0.

    From the halo, on a falling curve through the held states; above the halo's
    reach from the finger's own depth. The two are blended, so that there is no jump.
    """
    own_mm = tip.top_mm - states.finger_thickness_mm
    if signal.hidden or not states.hover.readings:
        return max(own_mm, 0.0) if math.isfinite(own_mm) else ONSET_MM
    rising = span(signal, states.hover, states.subtle)
    nothing = rising.at([0.0] * len(signal.readings))
    halo = rising.at(signal.readings) - nothing
    levels, heights = curve(states, rising, nothing)
    halo_mm = float(np.interp(halo, levels, heights))
    share = min(max(halo / (FADED * -nothing), 0.0), 1.0)
    if share == 1.0 or math.isnan(own_mm):
        return halo_mm
    return share * halo_mm + (1.0 - share) * max(own_mm, states.hover.height_mm)


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
