"""Stage 6: interpolation between the four calibrated states (paper 4.3.6, its one equation)."""

from __future__ import annotations

from halo_service.profile import TouchStates


def interpolate(x: float, x_min: float, x_max: float, y_min: float, y_max: float) -> float:
    """Map `x` from x_min..x_max to y_min..y_max on a straight line; not clamped."""
    return y_min + (x - x_min) / (x_max - x_min) * (y_max - y_min)


def touch_level(signal: float, states: TouchStates) -> float:
    """Return 0 at the subtle state, 1 at touch; beyond both ends the line goes on."""
    return interpolate(signal, states.subtle.signal, states.touch.signal, 0.0, 1.0)
