"""Stage 10: how hard a touching finger presses."""

from __future__ import annotations

from halo_service.profile import TouchStates
from halo_service.sensing.states import interpolate

LEAST_PRESSURE = 0.02
"""A touch always presses a little, so that pressure alone tells touch from hover."""
FORCE_UNKNOWN_G = -1.0


def touch_pressure(signal: float, states: TouchStates) -> float:
    """Return 0.02 at a relaxed touch, 1 at the calibrated press, more beyond (paper 4.3.6)."""
    pressure = interpolate(signal, states.touch.signal, states.pressure.signal, 0.0, 1.0)
    return max(pressure, LEAST_PRESSURE)


def force(pressure: float, states: TouchStates) -> float:
    """Return grams where the calibration knows its forces, else -1."""
    if states.touch.force_g < 0.0 or states.pressure.force_g < 0.0:
        return FORCE_UNKNOWN_G
    span_g = states.pressure.force_g - states.touch.force_g
    return states.touch.force_g + (0.0 if pressure <= LEAST_PRESSURE else pressure) * span_g
