"""The plane through points, by least squares and by RANSAC. Pure.

Not scikit-learn's, which gives the same planes: its import takes a second of every first start.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Points

TRIALS = 200
"""Planes through three points; with half of all points on the table, the best of 200 misses it
once in 10^12."""
MISSED = 1e-12
"""For this probability fewer trials are enough where a larger share of the points fits."""
INDEPENDENT = 1e-6
"""Points that are narrower than this share of their length lie on a line, and give no slope."""

Weights = NDArray[np.float64]


def ransac(points: Points, reach_mm: float) -> tuple[Points, float]:
    """Return normal and offset, mm, of the plane to which most of (N, 3) points are near in z.

    At least three points. The same points give the same plane.
    """
    rng = np.random.RandomState(0)
    best, trial, trials = np.zeros(len(points), np.bool_), 0, TRIALS
    while trial < trials:
        trial += 1
        a, b, c = _slopes(points[_three(rng, len(points))], None)
        near = np.abs(points[:, 2] - (points[:, :2] @ (a, b) + c)) <= reach_mm
        if np.count_nonzero(near) > np.count_nonzero(best):
            best = near
            trials = min(trials, _trials(np.count_nonzero(near) / len(points)))
    return least_squares(points[best])


def least_squares(points: Points, weight: Weights | None = None) -> tuple[Points, float]:
    """Return normal and offset, mm, of the plane through (N, 3) points; errors count in z.

    The normal is a unit vector and has a positive z. `weight`: (N,) at least 0.
    """
    a, b, c = _slopes(points, weight)
    length = math.sqrt(a * a + b * b + 1.0)
    return np.array([-a, -b, 1.0]) / length, c / length


def _slopes(points: Points, weight: Weights | None) -> tuple[float, float, float]:
    """Return a, b, c of z = a x + b y + c."""
    from scipy.linalg import lstsq  # here, because it is slow to import

    xy, z = points[:, :2].copy(), points[:, 2].copy()
    middle, mean_z = np.average(xy, axis=0, weights=weight), np.average(z, weights=weight)
    root = np.ones(len(points)) if weight is None else np.sqrt(weight)
    slopes = lstsq((xy - middle) * root[:, None], (z - mean_z) * root, cond=INDEPENDENT)[0]
    return float(slopes[0]), float(slopes[1]), float(mean_z - middle @ slopes)


def _three(rng: np.random.RandomState, count: int) -> list[int]:
    """Return three different numbers below a count of at least three."""
    drawn: list[int] = []
    while len(drawn) < 3:
        number = int(rng.randint(count))
        if number not in drawn:
            drawn.append(number)
    return drawn


def _trials(share: float) -> int:
    """Return how many trials are enough where so large a share of the points is on the plane."""
    missed = max(1.0 - share**3, float(np.spacing(1.0)))
    return math.ceil(math.log(MISSED) / math.log(missed))
