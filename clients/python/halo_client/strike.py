"""From the speed of a strike to its loudness, for every client that makes sound.

Rule: pure.
"""

from __future__ import annotations

from halo_protocol import UNKNOWN_STRIKE

SOFT = 0.25
"""Loudness of the softest strike, relative to the loudest."""
SOFT_MM_S, LOUD_MM_S = 0.0, 400.0
"""Speed of the softest and of the loudest strike."""
UNKNOWN_LEVEL = 0.6
"""Loudness if the speed was lost."""
CURVE = 0.6
"""Exponent from speed to loudness; below 1, so that soft strikes stay audible."""


def loudness(
    strike_mm_s: float,
    soft: float = SOFT,
    loud_mm_s: float = LOUD_MM_S,
    soft_mm_s: float = SOFT_MM_S,
) -> float:
    """Return the loudness of a strike, `soft` to 1."""
    if strike_mm_s == UNKNOWN_STRIKE:
        return UNKNOWN_LEVEL
    hard = (strike_mm_s - soft_mm_s) / (loud_mm_s - soft_mm_s)
    return float(soft + (1 - soft) * min(max(hard, 0.0), 1.0) ** CURVE)
