"""The fits of a plane give what an independent implementation gives."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression, RANSACRegressor

from halo_calibration.solvers.plane_fit import MISSED, TRIALS, least_squares, ransac
from halo_service.geometry.camera import Points

REACH_MM = 8.0


def cluttered(share: float) -> Points:
    """Return points of a table, with things on a share of it."""
    rng = np.random.default_rng(5)
    xy = rng.uniform(-150.0, 150.0, (3000, 2))
    z = 500.0 + 0.1 * xy[:, 0] - 0.05 * xy[:, 1] + rng.normal(0.0, 1.0, len(xy))
    thing = xy[:, 0] < -150.0 + 300.0 * share
    z[thing] -= rng.uniform(10.0, 90.0, np.count_nonzero(thing))
    return np.column_stack([xy, z])


def plane_of(fit: LinearRegression) -> tuple[Points, float]:
    normal = np.array([-fit.coef_[0], -fit.coef_[1], 1.0])
    length = float(np.linalg.norm(normal))
    return normal / length, float(fit.intercept_) / length


@pytest.mark.parametrize("share", [0.0, 0.1, 0.45])
def test_ransac_finds_the_plane_that_scikit_learn_finds(share: float) -> None:
    points = cluttered(share)
    theirs = RANSACRegressor(
        min_samples=3,
        residual_threshold=REACH_MM,
        max_trials=TRIALS,
        stop_probability=1.0 - MISSED,
        random_state=0,
    ).fit(points[:, :2], points[:, 2])
    normal, offset = ransac(points, REACH_MM)
    expected = plane_of(theirs.estimator_)
    np.testing.assert_allclose([*normal, offset], [*expected[0], expected[1]], rtol=1e-12)


def test_weighted_points_give_the_plane_that_scikit_learn_gives() -> None:
    points = cluttered(0.3)
    weight = np.random.default_rng(6).uniform(0.0, 1.0, len(points))
    theirs = LinearRegression().fit(points[:, :2], points[:, 2], weight)
    normal, offset = least_squares(points, weight)
    expected = plane_of(theirs)
    np.testing.assert_allclose([*normal, offset], [*expected[0], expected[1]], rtol=1e-12)
