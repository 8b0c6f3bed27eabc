"""Stage 6: interpolation between the four calibrated states (paper 4.3.6, its one equation)."""

from __future__ import annotations

import math

from halo_service.profile import TouchState, TouchStates
from halo_service.values import Signal


def interpolate(x: float, x_min: float, x_max: float, y_min: float, y_max: float) -> float:
    """Map `x` from x_min..x_max to y_min..y_max on a straight line; not clamped."""
    return y_min + (x - x_min) / (x_max - x_min) * (y_max - y_min)


def touch_level(signal: Signal, states: TouchStates) -> float:
    """Return 0 at the subtle state, 1 at touch; linear beyond both ends."""
    return interpolate(*readings(signal, states.subtle, states.touch), 0.0, 1.0)


def readings(signal: Signal, lower: TouchState, upper: TouchState) -> tuple[float, float, float]:
    """Return a signal's reading, and its readings in two states in contact or close to it.

    The dent under the finger, mm: a hand that hides most of the patch reduces the patch's sum but
    not the dent, which also grows on where the sum is cut off at the patch's edge. The sum, mm px,
    if the dent is hidden too or was not calibrated.
    """
    if math.isfinite(signal.pressed_mm) and upper.deep_mm > lower.deep_mm > 0.0:
        return signal.pressed_mm, lower.deep_mm, upper.deep_mm
    return signal.corrected, lower.signal, upper.signal
