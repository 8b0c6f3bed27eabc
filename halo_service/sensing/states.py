"""Stage 6: interpolation between the four calibrated states (paper 4.3.6, its one equation).

Several readings of one halo are averaged. Each weighs what the calibration shows it is worth
between two states: the square of their distance over the variance of the held frames and the sweep.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.profile import TouchState
from halo_service.values import Signal

LEAST_DEVIATION = 0.01
"""No reading repeats to less than this share of itself (chosen)."""


@dataclass(frozen=True, slots=True)
class Span:
    """A straight scale from one state, 0, to the next, 1: a weighted mean over the readings."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    weights: tuple[float, ...]
    """Their sum is 1; 0 for a reading that is hidden or does not grow between the two."""
    deviation: float
    """Standard deviation of a value on the scale, as if the readings erred alike."""

    def at(self, values: Sequence[float]) -> float:
        """Return where readings are on the scale; not clamped."""
        return sum(
            weight * interpolate(value, low, high, 0.0, 1.0)
            for weight, value, low, high in zip(
                self.weights, values, self.lower, self.upper, strict=True
            )
            if weight > 0.0
        )


def span(signal: Signal, lower: TouchState, upper: TouchState) -> Span:
    """Return the scale between two states for the readings that a frame shows."""
    low, high = values_of(lower), values_of(upper)
    noises = (lower.noise or (0.0,), upper.noise or (0.0,))
    variances = [
        _variance(*each)
        for each in zip(
            _values(signal, lower), low, high, *noises, deviations(signal), strict=False
        )
    ]
    worth = [1.0 / each for each in variances]
    total = sum(worth)
    if total == 0.0:  # nothing separates the two: the sum, which is never hidden
        return Span(low, high, (1.0, *(0.0 for _ in low[1:])), math.inf)
    weights = tuple(each / total for each in worth)
    mean = sum(w * v for w, v in zip(weights, variances, strict=True) if w > 0.0)
    return Span(low, high, weights, math.sqrt(mean))


def interpolate(x: float, x_min: float, x_max: float, y_min: float, y_max: float) -> float:
    """Map `x` from x_min..x_max to y_min..y_max on a straight line; not clamped."""
    return y_min + (x - x_min) / (x_max - x_min) * (y_max - y_min)


def at_calibrated_pitch(signal: Signal, state: TouchState) -> tuple[float, ...]:
    """Return the readings that a state has, as they would be at the pitch of the calibration."""
    return tuple(each / signal.at_pitch for each in _values(signal, state))


def values_of(state: TouchState) -> tuple[float, ...]:
    """Return a state's readings; the sum alone in a profile from before there were several."""
    return state.readings or (state.signal,)


def deviations(signal: Signal) -> tuple[float, ...]:
    """Return the relative standard deviation of each reading by its place."""
    return signal.deviations or (0.0,) * max(len(signal.readings), 1)


def _values(signal: Signal, state: TouchState) -> tuple[float, ...]:
    return signal.readings if state.readings else (signal.corrected,)


def _variance(
    value: float, low: float, high: float, low_noise: float, high_noise: float, deviation: float
) -> float:
    """Return a reading's variance on the scale from one state to the next."""
    apart = high - low
    noise = math.hypot(low_noise, high_noise) / math.sqrt(2.0)
    if not math.isfinite(value) or 0.0 in (low, high) or apart <= noise:
        return math.inf
    relative = math.hypot(deviation, LEAST_DEVIATION) * (low + high) / 2.0
    return (noise**2 + relative**2) / apart**2
