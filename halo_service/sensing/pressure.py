"""Stage 10: how hard a touching finger presses."""

from __future__ import annotations

import math
from collections.abc import Sequence

from halo_service.profile import TouchStates
from halo_service.sensing.states import Span, at_calibrated_pitch, interpolate, span, values_of
from halo_service.values import Signal

LEAST_PRESSURE = 0.02
"""A touch always presses a little, so that pressure alone separates touch from hover."""
FORCE_UNKNOWN_G = -1.0
GROWTH = 0.6
"""The halo grows with the pad's contact, and that with the force to this power: 2/3 for a round
elastic body (Hertz), less for flesh that stiffens. Chosen between 1/2 and 2/3, not fitted."""
TOUCH_G, PRESS_G = 25.0, 200.0
"""A relaxed touch and a medium press, if not stated (chosen)."""

PRIOR_PRESSES = 1.0
"""Before any reading, a force is the medium press, give or take as many of it (chosen: from nothing
to twice the press). Where the halo says little, it holds back estimates that are far off."""

Points = Sequence[tuple[float, float]]
"""Places of the held forces on a scale of the halo, rising, and the contacts there, g^GROWTH."""


def touch_pressure(signal: Signal, states: TouchStates) -> float:
    """Return 0.02 at a relaxed touch, 1 at the calibrated press, more beyond (paper 4.3.6).

    Linear in the force, so more than linear in the halo.
    """
    touch_g, press_g = _forces(states)
    pressed_g, _ = touch_force(signal, states)
    return max((pressed_g - touch_g) / (press_g - touch_g), LEAST_PRESSURE)


def touch_force(signal: Signal, states: TouchStates) -> tuple[float, float]:
    """Return the force and its standard deviation, grams; by assumed forces if none is stated.

    The mean of what the halo says and of what is known before, each weighted by its variance.
    """
    read_g, deviation_g = read_force(signal, states)
    if not 0.0 < deviation_g < math.inf:
        return read_g, deviation_g
    touch_g, press_g = _forces(states)
    weight, prior = deviation_g**-2, (PRIOR_PRESSES * press_g) ** -2
    mean_g = (weight * max(read_g, touch_g) + prior * press_g) / (weight + prior)
    return mean_g, (weight + prior) ** -0.5


def read_force(signal: Signal, states: TouchStates) -> tuple[float, float]:
    """Return the force by the halo alone and its standard deviation, grams.

    The latter is inf where the calibration does not show what the halo is worth.
    """
    scale, points = _curve(signal, states)
    at, off = scale.at(at_calibrated_pitch(signal, states.touch)), scale.deviation
    if math.isinf(off):
        return _grams(at, points), math.inf
    return _grams(at, points), (_grams(at + off, points) - _grams(at - off, points)) / 2.0


def force(pressure: float, states: TouchStates) -> float:
    """Return grams if the calibration states its forces, else -1."""
    if not knows_force(states):
        return FORCE_UNKNOWN_G
    span_g = states.pressure.force_g - states.touch.force_g
    return states.touch.force_g + (0.0 if pressure <= LEAST_PRESSURE else pressure) * span_g


def knows_force(states: TouchStates) -> bool:
    """Return whether the calibration states its forces."""
    return states.touch.force_g >= 0.0 and states.pressure.force_g >= 0.0


def _forces(states: TouchStates) -> tuple[float, float]:
    """Return the forces of the relaxed touch and of the medium press, g."""
    touch_g, press_g = states.touch.force_g, states.pressure.force_g
    return (touch_g, press_g) if 0.0 <= touch_g < press_g else (TOUCH_G, PRESS_G)


def _curve(signal: Signal, states: TouchStates) -> tuple[Span, Points]:
    """Return a scale through the held forces: up to the hard press where it was held."""
    touch_g, press_g = _forces(states)
    low, middle = touch_g**GROWTH, press_g**GROWTH
    if states.hard is not None and states.hard.force_g > press_g:
        scale = span(signal, states.touch, states.hard)
        held = values_of(states.pressure)
        shown = all(value != 0.0 for value, w in zip(held, scale.weights, strict=True) if w > 0.0)
        at_press = scale.at(held)
        if shown and 0.0 < at_press < 1.0:
            return scale, ((0.0, low), (at_press, middle), (1.0, states.hard.force_g**GROWTH))
    return span(signal, states.touch, states.pressure), ((0.0, low), (1.0, middle))


def _grams(at: float, points: Points) -> float:
    """Return the force at a place of the scale: straight between the points and beyond them."""
    upper = next((n for n in range(1, len(points) - 1) if at < points[n][0]), len(points) - 1)
    (x0, y0), (x1, y1) = points[upper - 1], points[upper]
    contact = interpolate(at, x0, x1, y0, y1)
    return math.pow(max(contact, 0.0), 1.0 / GROWTH)
