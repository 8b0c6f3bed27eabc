"""A constant-velocity Kalman filter of one fingertip on the surface.

x and y are independent and equally noisy, so both share one 2 x 2 covariance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Place = tuple[float, float]

JERKINESS_MM2_S3 = 3.0e6
"""Spectral density of the acceleration, white (chosen: in a frame a finger's velocity changes by
0.32 m/s, one standard deviation)."""
START_MM_S = 300.0
"""Standard deviation of a new finger's velocity (chosen: people move at 0.3 m/s)."""
LONGEST_S = 0.07
"""A finger that is not measured is moved on for so long and no farther (chosen: two frames)."""


@dataclass(frozen=True, slots=True)
class Kalman:
    """A state at a time, with its covariance."""

    time_us: int
    place_mm: Place
    velocity_mm_s: Place
    place_mm2: float
    """Variance of the place."""
    both_mm2_s: float
    """Covariance of place and velocity."""
    velocity_mm2_s2: float
    """Variance of the velocity."""


def born(time_us: int, place_mm: Place, sigma_mm: float) -> Kalman:
    """Return the state after a first measurement with a standard deviation."""
    return Kalman(time_us, place_mm, (0.0, 0.0), sigma_mm**2, 0.0, START_MM_S**2)


def predicted(state: Kalman, time_us: int) -> Kalman:
    """Return the state at a later time; an earlier one changes nothing."""
    s = max(time_us - state.time_us, 0) / 1e6
    moved_s = min(s, LONGEST_S)
    (x, y), (vx, vy) = state.place_mm, state.velocity_mm_s
    p, c, v, q = state.place_mm2, state.both_mm2_s, state.velocity_mm2_s2, JERKINESS_MM2_S3
    return Kalman(
        max(time_us, state.time_us),
        (x + moved_s * vx, y + moved_s * vy),
        state.velocity_mm_s,
        p + 2.0 * s * c + s * s * v + q * s**3 / 3.0,
        c + s * v + q * s * s / 2.0,
        v + q * s,
    )


def carried(state: Kalman, time_us: int, shift_mm: Place, sigma_mm: float) -> Kalman:
    """Return the state at a later time; its way since then was measured, with a deviation."""
    ahead = predicted(state, time_us)
    s = max(time_us - state.time_us, 0) / 1e6
    c, v, q = state.both_mm2_s, state.velocity_mm2_s2, JERKINESS_MM2_S3
    (x, y), (vx, vy) = state.place_mm, state.velocity_mm_s
    way_mm2 = s * s * v + q * s**3 / 3.0
    with_place, with_velocity = s * c + way_mm2, s * v + q * s * s / 2.0
    total = way_mm2 + sigma_mm**2
    gain, gain_per_s = with_place / total, with_velocity / total
    off_x, off_y = shift_mm[0] - s * vx, shift_mm[1] - s * vy
    return Kalman(
        ahead.time_us,
        (x + s * vx + gain * off_x, y + s * vy + gain * off_y),
        (vx + gain_per_s * off_x, vy + gain_per_s * off_y),
        ahead.place_mm2 - gain * with_place,
        ahead.both_mm2_s - gain * with_velocity,
        ahead.velocity_mm2_s2 - gain_per_s * with_velocity,
    )


def corrected(state: Kalman, place_mm: Place, sigma_mm: float) -> Kalman:
    """Return the state after a measurement at its own time."""
    p, c, v = state.place_mm2, state.both_mm2_s, state.velocity_mm2_s2
    total = p + sigma_mm**2
    gain, gain_per_s = p / total, c / total
    (x, y), (vx, vy) = state.place_mm, state.velocity_mm_s
    off_x, off_y = place_mm[0] - x, place_mm[1] - y
    return Kalman(
        state.time_us,
        (x + gain * off_x, y + gain * off_y),
        (vx + gain_per_s * off_x, vy + gain_per_s * off_y),
        (1.0 - gain) * p,
        (1.0 - gain) * c,
        v - gain_per_s * c,
    )


def distance(state: Kalman, place_mm: Place, sigma_mm: float) -> float:
    """Return the Mahalanobis distance of a measurement, in standard deviations."""
    return math.dist(state.place_mm, place_mm) / math.hypot(math.sqrt(state.place_mm2), sigma_mm)
