"""From sweeps to how deep a touch's dent is over place and pitch. Pure.

The dent is smooth, and its depth gives touch and force: one per cent of it is twenty grams. A
regressor's steps are larger than that, so smooth curves are fitted: over the place from the user's
own sweep, over the pitch, where the wedge covers one value only, from the base model.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halo_calibration.solvers.sweep import Samples

Floats = NDArray[np.float64]

ORDER = 3
"""Of the polynomials: a slope, a fall towards the edges, and that one edge is not the other."""
PER_MM, PER_DEG = 0.01, 0.05
"""Make places and pitches about 1."""
ROUNDS, OUTLIER_SIGMAS = 4, 3.0
"""A sample that lies farther off than this is left out of the next round: a misread finger."""
LEAST_SAMPLES = 100
"""Fewer give no curve: three seconds of a sweep."""
MOST_CHANGE = 1.5
"""No dent is corrected by a larger factor: beyond it the samples are wrong."""
KNOWN_PITCH_DEG = (30.0, 60.0)
"""Between the outermost wedges but one; beyond them fingers are misread, and the curve stays."""


def by_place(samples: Samples, x_mm: Floats, y_mm: Floats, at: tuple[float, float]) -> Floats:
    """Return the (x, y) grid of a touch's dent over that at a place; ones for too few samples.

    Beyond where the finger was drawn, the edge goes on.
    """
    seen = _usable(samples)
    if len(seen) < LEAST_SAMPLES:
        return np.ones((len(x_mm), len(y_mm)))
    low, high = np.percentile(seen[:, :2], (1.0, 99.0), axis=0)
    middle = (low + high) / 2.0

    def terms(places: Floats) -> Floats:
        return _plane((np.clip(places, low, high) - middle) * PER_MM)

    weights = _fitted(terms(seen[:, :2]), np.log(seen[:, 5]))
    grid = np.stack(np.meshgrid(x_mm, y_mm, indexing="ij"), axis=-1).reshape(-1, 2)
    strength = _bounded(terms(grid) @ weights - terms(np.array([at])) @ weights)
    return strength.reshape(len(x_mm), len(y_mm))


def by_pitch(samples: Samples, pitch_deg: Floats, at_deg: float) -> Floats:
    """Return a touch's dent at pitches over that at one of them; ones for too few samples.

    `samples`: of a base model.
    """
    seen = _usable(samples)
    if len(seen) < LEAST_SAMPLES:
        return np.ones(len(pitch_deg))

    def terms(pitches: Floats) -> Floats:
        slant = (np.clip(pitches, *KNOWN_PITCH_DEG) - 45.0) * PER_DEG
        return np.column_stack([slant**n for n in range(1, ORDER + 1)])

    # The place is fitted at the same time, so that it does not pass for pitch.
    weights = _fitted(
        np.column_stack([_plane(seen[:, :2] * PER_MM), terms(seen[:, 2])]), np.log(seen[:, 5])
    )[-ORDER:]
    return _bounded(terms(pitch_deg) @ weights - terms(np.array([at_deg])) @ weights)


def _usable(samples: Samples) -> Samples:
    return samples[samples[:, 5] > 0.0]  # false for nan: hidden


def _plane(places: Floats) -> Floats:
    """Return the terms of a polynomial over the plane; (N, 2) to (N, terms)."""
    x, y = places.T
    powers = [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]
    return np.column_stack([x**i * y**j for i, j in powers])


def _fitted(terms: Floats, values: Floats) -> Floats:
    """Return the weights of the terms, by least squares without what lies far off."""
    inliers = np.ones(len(values), np.bool_)
    for _ in range(ROUNDS):
        weights = np.linalg.lstsq(terms[inliers], values[inliers], rcond=None)[0]
        off = np.abs(values - terms @ weights)
        inliers = off < OUTLIER_SIGMAS * 1.4826 * np.median(off[inliers]) + 1e-6
    return np.asarray(weights)


def _bounded(logarithm: Floats) -> Floats:
    return np.asarray(np.clip(np.exp(logarithm), 1.0 / MOST_CHANGE, MOST_CHANGE))
