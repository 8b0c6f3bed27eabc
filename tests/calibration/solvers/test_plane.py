"""The plane is found through noise, lens and things on the table."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.plane import solve_plane, surface_from_view
from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import from_view
from halo_service.profile import Background

Seen = Callable[..., Background]


@pytest.fixture
def seen(lens_camera: Camera) -> Seen:
    """What the camera sees of a plane, with noise."""

    def look(tilt_deg: float, distance_mm: float, turn_deg: float = 30.0) -> Background:
        tilt, turn = np.radians(tilt_deg), np.radians(turn_deg)
        normal = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
        lens = lens_camera.depth
        rows, columns = np.mgrid[: lens.height, : lens.width]
        px = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
        depth = distance_mm * normal[2] / (lens.rays(px) @ normal)
        depth += np.random.default_rng(1).normal(0.0, 0.5, depth.shape)
        mean = depth.reshape(lens.height, lens.width).astype(np.float32)
        return Background(mean, np.ones_like(mean), np.ones(mean.shape, bool))

    return look


@pytest.mark.parametrize("distance_mm", [450.0, 700.0])
@pytest.mark.parametrize("tilt_deg", [0.0, 5.0, 30.0])
@pytest.mark.parametrize("thing", [False, True], ids=["clear", "a box"])
def test_the_plane_is_found(
    seen: Seen, lens_camera: Camera, tilt_deg: float, distance_mm: float, thing: bool
) -> None:
    background = seen(tilt_deg, distance_mm)
    if thing:
        background.mean_mm[60:240, 380:600] -= 80.0
        background.valid[300:310, 300:340] = False
    plane = solve_plane(background, lens_camera)
    assert plane.distance_mm == pytest.approx(distance_mm, abs=0.3)
    assert plane.tilt_deg == pytest.approx(tilt_deg, abs=0.05)
    assert plane.residual_mm < 0.8
    if thing:
        assert plane.left_out == pytest.approx(180 * 220 / (640 * 576), abs=0.02)
        assert "far right" in plane.note
        assert "above the plane" in plane.note
    else:
        assert plane.note == ""


@pytest.mark.parametrize("height_mm", [5.0, 10.0])
def test_a_low_thing_does_not_tilt_the_plane(
    seen: Seen, lens_camera: Camera, height_mm: float
) -> None:
    background = seen(5.0, 500.0)
    background.mean_mm[60:300, 330:600] -= height_mm  # a book on a sixth of the view
    plane = solve_plane(background, lens_camera)
    assert plane.distance_mm == pytest.approx(500.0, abs=0.05)
    assert plane.tilt_deg == pytest.approx(5.0, abs=0.01)


def test_the_surface_lies_around_the_optical_axis(seen: Seen, lens_camera: Camera) -> None:
    plane = solve_plane(seen(5.0, 500.0), lens_camera)
    surface = surface_from_view(plane)
    middle = surface.to_camera(np.array([[150.0, 100.0, 0.0]]))[0]
    np.testing.assert_allclose(middle, [0.0, 0.0, 500.0], atol=0.5)
    rotation = surface.camera_from_surface[:3, :3]
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert rotation[1, 1] > 0.9  # towards the user is down in the picture
    expected = from_view(np.array(plane.normal), plane.distance_mm).camera_from_surface
    np.testing.assert_array_equal(surface.camera_from_surface, expected)


def test_a_view_without_depth_shows_no_halo(seen: Seen, lens_camera: Camera) -> None:
    background = seen(0.0, 500.0)
    background.valid[::2] = False
    background.valid[:, ::3] = False
    with pytest.raises(CalibrationError, match="this surface shows no halo"):
        solve_plane(background, lens_camera)


def test_a_heap_is_no_surface(seen: Seen, lens_camera: Camera) -> None:
    background = seen(0.0, 500.0)
    heap = np.random.default_rng(2).uniform(-200.0, 0.0, (36, 40)).astype(np.float32)
    background.mean_mm[:] += np.kron(heap, np.ones((16, 16), np.float32))
    with pytest.raises(CalibrationError, match="no flat surface"):
        solve_plane(background, lens_camera)


def test_a_surface_seen_from_the_side_is_refused(seen: Seen, lens_camera: Camera) -> None:
    with pytest.raises(CalibrationError, match="55 degrees"):
        solve_plane(seen(55.0, 500.0, turn_deg=0.0), lens_camera)
