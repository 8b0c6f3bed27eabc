"""Stage 9: the height of the pad above the surface."""

from __future__ import annotations

import math

from halo_service.profile import TouchStates
from halo_service.sensing.states import interpolate
from halo_service.values import Fingertip, Signal

LINE_REACH_MM = 15.0
"""Where the last halo pixel on the finger's line is gone (paper 4.3.6)."""


def hover_height(signal: Signal, tip: Fingertip, states: TouchStates) -> float:
    """Return the pad's height, mm, at least 0.

    Between the subtle and hover states it is read off the halo, up to 15 mm off the halo pixels
    left on the finger's line, and above that off the fingertip's own depth, which is coarser.
    """
    if signal.corrected > states.hover.signal:
        height = interpolate(
            signal.corrected,
            states.hover.signal,
            states.subtle.signal,
            states.hover.height_mm,
            states.subtle.height_mm,
        )
        return max(height, 0.0)
    if 0 < signal.line_px <= states.line_px_at_hover:
        return interpolate(
            signal.line_px, 0.0, states.line_px_at_hover, LINE_REACH_MM, states.hover.height_mm
        )
    if math.isnan(tip.top_mm):
        return LINE_REACH_MM
    return max(tip.top_mm - states.finger_thickness_mm, states.hover.height_mm)
