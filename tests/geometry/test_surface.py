"""Places on a surface map to pixels of both lenses and back."""

import numpy as np
import pytest

from halo_service.geometry.surface import Surface, from_view
from halo_service.virtual.camera import factory

CAMERA = factory()
LENSES = {
    "depth": (CAMERA.depth, np.eye(4)),
    "colour": (CAMERA.colour, CAMERA.colour_from_depth),
}


def tilted(pitch_deg, yaw_deg, distance_mm=600.0) -> Surface:
    pitch, yaw = np.radians(pitch_deg), np.radians(yaw_deg)
    normal = np.array([-np.sin(yaw), np.sin(pitch) * np.cos(yaw), np.cos(pitch) * np.cos(yaw)])
    return from_view(normal, distance_mm)


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize(("pitch_deg", "yaw_deg"), [(0, 0), (15, 0), (-30, 20)])
def test_a_pixel_sees_the_place_that_projects_to_it(lens, pitch_deg, yaw_deg):
    surface = tilted(pitch_deg, yaw_deg)
    places = np.array([[0.0, 0.0], [300.0, 200.0], [150.0, 100.0], [-40.0, 230.0]])
    px = surface.in_picture(places, *LENSES[lens])
    np.testing.assert_allclose(surface.seen_at(px, *LENSES[lens]), places, atol=1e-3)
    assert surface.seen_at(px[:0], *LENSES[lens]).shape == (0, 2)


def test_both_lenses_see_the_same_place():
    surface = tilted(10.0, -5.0)
    places = np.array([[20.0, 30.0], [280.0, 170.0]])
    seen = [surface.seen_at(surface.in_picture(places, *lens), *lens) for lens in LENSES.values()]
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-3)


def test_a_pixel_above_the_horizon_sees_no_place():
    surface = tilted(80.0, 0.0)
    px = np.array([[320.0, 20.0], [320.0, 560.0]])
    nowhere, somewhere = surface.seen_at(px, *LENSES["depth"])
    assert np.isnan(nowhere).all() != np.isnan(somewhere).all()


def test_a_moved_surface_is_on_the_same_plane():
    surface = tilted(12.0, 7.0)
    turn = np.radians(30.0)
    shift = np.array(
        [[np.cos(turn), -np.sin(turn), 40.0], [np.sin(turn), np.cos(turn), -25.0], [0, 0, 1.0]]
    )
    other = surface.moved(shift, 500.0, 250.0)
    assert (other.name, other.width_mm, other.height_mm) == ("table", 500.0, 250.0)
    here = np.array([[100.0, 50.0, 0.0], [0.0, 0.0, 0.0], [30.0, 10.0, -20.0]])
    there = surface.from_camera(other.to_camera(here))
    np.testing.assert_allclose(there[:, 2], here[:, 2], atol=1e-9)
    np.testing.assert_allclose(there[1, :2], [40.0, -25.0], atol=1e-9)
    np.testing.assert_allclose(there[0, :2], (shift @ (100.0, 50.0, 1.0))[:2], atol=1e-9)
