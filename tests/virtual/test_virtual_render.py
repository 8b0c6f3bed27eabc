"""The renderer against bodies whose image is known in closed form."""

import numpy as np
import pytest

from halo_service.virtual.bodies import Body, cup, wedge
from halo_service.virtual.camera import factory, pixel_rays
from halo_service.virtual.depth_image import DepthImager
from halo_service.virtual.mesh import gradient, surface_nets
from halo_service.virtual.render import _project, rasterise
from halo_service.virtual.room import Room, draw_room

RADIUS = 40.0


def ball(x, y, z, step=4.0):
    def field(points):
        return np.linalg.norm(points, axis=1) - RADIUS

    axis = np.arange(-48.0, 49.0, step)
    vertices, faces = surface_nets(field, (axis, axis, axis))
    return vertices + np.array([x, y, z]), faces, gradient(field, vertices)


def hit(rays, centre):
    """(N,) depth where rays from the origin meet the ball, NaN where they miss."""
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    along = unit @ centre
    inside = RADIUS**2 - (centre @ centre - along**2)
    distance = along - np.sqrt(np.where(inside > 0, inside, np.nan))
    return distance * unit[:, 2]


@pytest.mark.parametrize("x, y", [(0.0, 0.0), (-150.0, 120.0), (200.0, -90.0)])
def test_a_ball_is_seen_where_it_is_and_as_deep_as_it_is(x, y):
    lens = factory().depth
    points, faces, _ = ball(x, y, 500.0)
    seen = rasterise(lens, points, faces)
    assert len(np.unique(seen.pixel)) == len(seen.pixel)
    depth = seen.mix(points[:, 2:].T.astype(np.float32))[0]
    true = hit(pixel_rays(lens).reshape(-1, 3), np.array([x, y, 500.0]))
    covered = np.flatnonzero(~np.isnan(true))
    wrong = np.setxor1d(covered, seen.pixel)
    assert len(wrong) < 0.03 * len(covered)  # facets cut the outline a little
    error = depth - true[seen.pixel]
    assert np.nanmedian(np.abs(error)) < 0.15


def test_what_is_behind_the_lens_or_outside_the_image_is_not_seen():
    lens = factory().depth
    for place in ((0.0, 0.0, -400.0), (5000.0, 0.0, 500.0), (0.0, 0.0, 20.0)):
        points, faces, _ = ball(*place)
        assert len(rasterise(lens, points, faces).pixel) == 0


@pytest.mark.parametrize("depth_mm", [3e-5, 1e-9, 1e-20, 0.0, -1e-9])
def test_an_arm_as_high_as_the_lens_is_not_seen_and_overflows_nothing(depth_mm):
    """As at user 216, 430 mm below the camera: an upper arm rises beyond it."""
    points = np.array([[1147.0, 190.0, depth_mm], [1147.0, 240.0, -depth_mm], [1050.0, 190.0, 9.0]])
    for faces in ([[0, 1, 2]], [[0, 2, 1]]):
        with np.errstate(all="raise"):
            assert len(rasterise(factory().depth, points, np.array(faces)).pixel) == 0


def test_pixels_are_those_of_the_lens():
    rng = np.random.default_rng(3)
    points = rng.uniform((-600.0, -500.0, 100.0), (600.0, 500.0, 900.0), (2000, 3))
    for lens in (factory().depth, factory().colour, factory("bolt", "WFOV_2X2BINNED").depth):
        x, y, z = _project(lens, points)
        seen = z > 0.0
        assert 500 < np.count_nonzero(seen) < 2000
        assert (z[seen] == points[seen, 2].astype(np.float32)).all()
        px = lens.project(points[seen]).astype(np.float32)
        assert (np.column_stack([x, y])[seen] == px).all()


def test_the_nearer_of_two_bodies_hides_the_other():
    lens = factory().depth
    near, faces, _ = ball(0.0, 0.0, 400.0)
    far = ball(10.0, 0.0, 600.0)[0]
    both = np.concatenate([far, near]), np.concatenate([faces, faces + len(far)])
    seen = rasterise(lens, *both)
    alone = rasterise(lens, near, faces)
    assert np.isin(alone.pixel, seen.pixel).all()
    corner = seen.corner[np.isin(seen.pixel, alone.pixel)]
    assert (corner >= len(far)).all()


@pytest.mark.parametrize("body", [cup(150.0, 100.0), wedge(150.0, 100.0, 30.0)])
def test_solid_things_stand_on_the_table_with_their_faces_outward(body: Body):
    assert body.vertices[:, 2].max() == pytest.approx(0.0)
    a, b, c = (body.vertices[body.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    outward = (a + b + c) / 3.0 - body.vertices.mean(axis=0)
    assert (np.einsum("ij,ij->i", across, outward) > 0.0).all()
    assert np.einsum("ij,ij->i", across, body.normals[body.faces[:, 0]]).min() > 0.0


@pytest.mark.parametrize("pitch, yaw", [(0.0, 0.0), (4.0, -3.0), (-20.0, 10.0)])
def test_the_empty_table_is_the_rooms_plane(pitch, yaw):
    room = Room(camera_pitch_deg=pitch, camera_yaw_deg=yaw)
    surface = room.surface()
    imager = DepthImager(room, factory(), surface)
    ideal = imager.draw([])
    rays = pixel_rays(factory().depth)[::37, ::41].reshape(-1, 3)
    points = surface.from_camera(rays * ideal.depth[::37, ::41].reshape(-1, 1))
    assert np.abs(points[:, 2]).max() < 0.01
    middle = surface.from_camera(np.array([[0.0, 0.0, room.camera_height_mm]]))
    assert middle[0] == pytest.approx([150.0, 100.0, 0.0], abs=1e-9)


def test_the_surface_has_its_origin_at_the_top_left_and_is_right_handed():
    for seed in range(5):
        surface = draw_room(seed).surface()
        rotation = surface.camera_from_surface[:3, :3]
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        px = factory().depth.project(
            surface.to_camera(np.array([[0.0, 0, 0], [300.0, 0, 0], [0, 200.0, 0]]))
        )
        assert px[1, 0] > px[0, 0] + 100
        assert px[2, 1] > px[0, 1] + 100
