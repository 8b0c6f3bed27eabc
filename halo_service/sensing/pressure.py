"""Stage 10: how hard a touching finger presses."""

from __future__ import annotations

from halo_service.profile import TouchStates
from halo_service.sensing.states import between, interpolate
from halo_service.values import Signal

LEAST_PRESSURE = 0.02
"""A touch always presses a little, so that pressure alone separates touch from hover."""
FORCE_UNKNOWN_G = -1.0
GROWTH = 0.6
"""The halo grows with the pad's contact, and that with the force to this power: 2/3 for a round
elastic body (Hertz), less for flesh that stiffens. Chosen between 1/2 and 2/3, not fitted."""
TOUCH_G, PRESS_G = 25.0, 200.0
"""A relaxed touch and a medium press, if not stated (chosen)."""


def touch_pressure(signal: Signal, states: TouchStates) -> float:
    """Return 0.02 at a relaxed touch, 1 at the calibrated press, more beyond (paper 4.3.6).

    Linear in the force, so more than linear in the halo.
    """
    touch, press = states.touch, states.pressure
    touch_g, press_g = touch.force_g, press.force_g
    if not 0.0 <= touch_g < press_g:
        touch_g, press_g = TOUCH_G, PRESS_G
    contact = interpolate(
        between(signal, touch, press), 0.0, 1.0, float(touch_g**GROWTH), float(press_g**GROWTH)
    )
    force_g = float(max(contact, 0.0) ** (1.0 / GROWTH))
    return max((force_g - touch_g) / (press_g - touch_g), LEAST_PRESSURE)


def force(pressure: float, states: TouchStates) -> float:
    """Return grams if the calibration states its forces, else -1."""
    if states.touch.force_g < 0.0 or states.pressure.force_g < 0.0:
        return FORCE_UNKNOWN_G
    span_g = states.pressure.force_g - states.touch.force_g
    return states.touch.force_g + (0.0 if pressure <= LEAST_PRESSURE else pressure) * span_g
