"""Pixels become rays in the whole image, in its corners too."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.geometry.camera import FEW
from tests.drawn import WIDE


def test_neighbouring_pixels_in_a_corner_beyond_the_image_circle_have_neighbouring_rays() -> None:
    px = np.column_stack([np.full(200, 70.0), np.linspace(69.0, 75.0, 200)])
    steps = np.abs(np.diff(WIDE.rays(px), axis=0)).max(axis=1)
    assert steps.max() < 0.01


def test_a_ray_within_the_image_circle_projects_to_its_pixel() -> None:
    px = np.column_stack([np.linspace(120.0, 400.0, 50), np.linspace(140.0, 380.0, 50)])
    assert WIDE.project(WIDE.rays(px)) == pytest.approx(px, abs=0.01)


def test_many_points_project_to_the_same_numbers_as_few() -> None:
    points = np.random.default_rng(1).uniform((-900, -900, -50), (900, 900, 900), (2 * FEW, 3))
    points[0, 2] = 0.0  # as far off the lens as can be
    few = np.concatenate([WIDE.project(points[:FEW]), WIDE.project(points[FEW:])])
    np.testing.assert_allclose(WIDE.project(points), few, rtol=1e-12)
