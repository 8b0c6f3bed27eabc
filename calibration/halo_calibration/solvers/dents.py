"""From sweeps to how each reading of a touch changes over place and pitch. Pure.

The halo is smooth, and its depth gives touch and force: one per cent of it is twenty grams. A
regressor's steps are larger than that, so smooth curves are fitted: over the place from the user's
own sweep, over the pitch, where the wedge covers one value only, from the base model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_calibration.solvers.sweep import READINGS, TOP, Samples

Floats = NDArray[np.float64]

ORDER = 3
"""Of the polynomials: a slope, a fall towards the edges, and that one edge is not the other."""
POWERS = [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]
PLANE = [i + j for i, j in POWERS]
"""Powers of x and y in each term over the plane, and its order."""
PER_MM, PER_DEG = 0.01, 0.05
"""Make places and pitches about 1."""
ROUNDS, OUTLIER_SIGMAS = 4, 3.0
"""A sample that lies farther off than this is left out of the next round: a misread finger."""
LEAST_SAMPLES = 100
"""Fewer give no curve: three seconds of a sweep at 30 frames a second."""
SLOPE = 1.0
"""Standard deviation that a slope of the logarithm has before any sample, per unit; halved with
each power. It holds what the samples do not determine near 1, and limits nothing that they do
(chosen: a halo may change by half its strength over the surface)."""
CORRELATED = 15
"""Samples in a row that count as one: half a second at 30 frames a second, in which a finger is
misread alike. A slower camera counts as less certain than it is."""
TOP_MM = 20.0
"""The finger's upper side may read higher or lower by so much where a halo may change by a factor
of e (chosen: at 430 mm in a wide mode it changes by 30 mm over the surface)."""
KNOWN_PITCH_DEG = (30.0, 60.0)
"""Between the outermost wedges but one; beyond them fingers are misread, and the curve stays."""


@dataclass(frozen=True, slots=True, eq=False)
class ByPlace:
    """One reading of a touch over the surface."""

    strength: Floats
    """(x, y) over that at a place."""
    deviation: Floats
    """(x, y) standard deviation of its logarithm: of the curve, and of one frame around it."""


def by_place(
    samples: Samples, x_mm: Floats, y_mm: Floats, at: tuple[float, float], column: int = 5
) -> ByPlace:
    """Return the grid of a touch's reading, in a column of the samples, over that at a place.

    Beyond where the finger was drawn, the edge goes on. Too few samples correct nothing.
    """
    seen = _usable(samples, column)
    if len(seen) < LEAST_SAMPLES:
        return ByPlace(np.ones((len(x_mm), len(y_mm))), np.ones((len(x_mm), len(y_mm))))
    change, deviation = _over_place(seen[:, :2], np.log(seen[:, column]), x_mm, y_mm, at)
    return ByPlace(np.exp(change), deviation)


def top_by_place(
    samples: Samples, x_mm: Floats, y_mm: Floats, at: tuple[float, float]
) -> tuple[Floats, Floats] | None:
    """Return how much higher a touching finger's upper side reads than at a place, mm.

    That is a grid (x, y), and the standard deviation of one frame around it; None for too few
    samples. A camera sees a finger from another side at each place, and reads its round upper side
    at another height.
    """
    seen = samples[np.isfinite(samples[:, TOP])]
    if len(seen) < LEAST_SAMPLES:
        return None
    change, deviation = _over_place(seen[:, :2], seen[:, TOP] / TOP_MM, x_mm, y_mm, at)
    return TOP_MM * change, TOP_MM * deviation


def _over_place(
    places: Floats, values: Floats, x_mm: Floats, y_mm: Floats, at: tuple[float, float]
) -> tuple[Floats, Floats]:
    """Return the grid (x, y) of a smooth value less that at a place, and its deviation."""
    low, high = np.percentile(places, (1.0, 99.0), axis=0)
    middle = (low + high) / 2.0

    def terms(at_mm: Floats) -> Floats:
        return _plane((np.clip(at_mm, low, high) - middle) * PER_MM)

    fit = _fitted(terms(places), values, PLANE)
    grid = np.stack(np.meshgrid(x_mm, y_mm, indexing="ij"), axis=-1).reshape(-1, 2)
    change = terms(grid) - terms(np.array([at]))
    of_curve = np.einsum("ni,ij,nj->n", change, fit.covariance, change)
    shape = len(x_mm), len(y_mm)
    deviation = np.sqrt(of_curve + fit.variance)
    return (change @ fit.weights).reshape(shape), deviation.reshape(shape)


def least_variation(samples: Samples) -> float:
    """Return what the place leaves unexplained of the steadiest reading, as a share of it."""
    middle = np.median(samples[:, :2], axis=0)
    x_mm, y_mm = middle[:1], middle[1:]
    at = float(middle[0]), float(middle[1])
    return min(
        float(by_place(samples, x_mm, y_mm, at, column).deviation[0, 0]) for column in READINGS
    )


def by_pitch(samples: Samples, pitch_deg: Floats, at_deg: float) -> Floats:
    """Return a touch's dent at pitches over that at one of them; ones for too few samples.

    `samples`: of a base model.
    """
    seen = _usable(samples, 5)
    if len(seen) < LEAST_SAMPLES:
        return np.ones(len(pitch_deg))

    def terms(pitches: Floats) -> Floats:
        slant = (np.clip(pitches, *KNOWN_PITCH_DEG) - 45.0) * PER_DEG
        return np.column_stack([slant**n for n in range(1, ORDER + 1)])

    # The place is fitted at the same time, so that it does not pass for pitch.
    weights = _fitted(
        np.column_stack([_plane(seen[:, :2] * PER_MM), terms(seen[:, 2])]),
        np.log(seen[:, 5]),
        [*PLANE, *range(1, ORDER + 1)],
    ).weights[-ORDER:]
    return np.asarray(np.exp(terms(pitch_deg) @ weights - terms(np.array([at_deg])) @ weights))


def _usable(samples: Samples, column: int) -> Samples:
    return samples[samples[:, column] > 0.0]  # false for nan: hidden


def _plane(places: Floats) -> Floats:
    """Return the terms of a polynomial over the plane; (N, 2) to (N, terms)."""
    x, y = places.T
    return np.column_stack([x**i * y**j for i, j in POWERS])


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    weights: Floats
    covariance: Floats
    variance: float
    """Of one sample."""


def _fitted(terms: Floats, values: Floats, orders: Sequence[int]) -> _Fit:
    """Fit the weights of the terms, by ridge regression without what lies far off.

    `orders`: of the terms; a constant, 0, is free.
    """
    prior = np.diag([order and (2.0 ** (order - 1) / SLOPE) ** 2 for order in orders])
    inliers = np.ones(len(values), np.bool_)
    variance = 1.0
    for _ in range(ROUNDS):
        used = terms[inliers]
        normal = used.T @ used + CORRELATED * variance * prior
        weights = np.linalg.solve(normal, used.T @ values[inliers])
        off = np.abs(values - terms @ weights)
        sigma = 1.4826 * float(np.median(off[inliers])) + 1e-6
        inliers, variance = off < OUTLIER_SIGMAS * sigma, sigma**2
    return _Fit(weights, CORRELATED * variance * np.linalg.inv(normal), variance)
