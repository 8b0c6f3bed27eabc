"""A printed marker's pose, lying on the surface or standing over it."""

import dataclasses

import numpy as np
import pytest

from halo_calibration.anchor_solver import anchor_pose
from halo_calibration.boards import anchor
from halo_calibration.errors import Refused
from halo_service.virtual.props import printed, standing
from tests.placed import Place, room

TAG = anchor("apriltag-36h11", 0, 80.0)
ARUCO = anchor("aruco-4x4", 70, 60.0)


def about(axis, degrees):
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = ((1, 2), (0, 2), (0, 1))[axis]
    turn = np.eye(3)
    turn[[i, j], [i, j]] = cos
    turn[i, j], turn[j, i] = -sin, sin
    return turn


def pose(x, y, z, turn_deg, tilt_deg=0.0, roll_deg=0.0):
    """surface_from_anchor."""
    matrix = np.eye(4)
    matrix[:3, :3] = about(2, turn_deg) @ about(0, tilt_deg) @ about(1, roll_deg)
    matrix[:3, 3] = (x, y, z)
    return matrix


def seen_in(place, marker, there):
    """Solve a marker that is put in a place: flat ones are printed, others stand."""
    width_mm = 1.4 * marker.size_mm
    picture = marker.picture(width_mm, width_mm, 5)
    bare, things = place.room, ()
    if there[2, 3] == 0.0:
        turn_deg = np.degrees(np.arctan2(there[1, 0], there[0, 0]))
        sheet = printed(picture, there[0, 3], there[1, 3], width_mm, turn_deg)
        furnished = dataclasses.replace(bare, sheets=(sheet,))
    else:
        things, furnished = (standing(picture, width_mm, there),), bare
    return anchor_pose(
        place.colour(things=things, room=furnished),
        marker,
        place.camera,
        place.plane,
        place.background,
        place.depths(furnished, things),
    )


CAMERAS = [(450.0, 0.0, "720P"), (700.0, 15.0, "1080P"), (1000.0, -10.0, "720P")]


@pytest.fixture(scope="module", params=CAMERAS, ids=lambda case: f"{case[0]:.0f} mm")
def place(request):
    height_mm, pitch_deg, resolution = request.param
    return Place(room(height_mm, pitch_deg, 5.0, material="wood", light=0.8), resolution)


@pytest.mark.parametrize(
    ("marker", "there"),
    [
        (TAG, pose(60.0, 50.0, 0.0, 20.0)),
        (ARUCO, pose(200.0, 120.0, 0.0, -160.0)),
        (TAG, pose(240.0, 150.0, -40.0, -30.0)),
        (TAG, pose(100.0, 140.0, -50.0, 70.0, 20.0, -10.0)),
        (ARUCO, pose(150.0, 60.0, -30.0, 170.0, -8.0, 3.0)),
    ],
    ids=["tag lies", "aruco lies", "tag on a box", "tag leans", "aruco leans"],
)
def test_the_anchor_is_found(place, marker, there):
    found = seen_in(place, marker, there)
    ours = np.linalg.inv(found.anchor.anchor_from_surface)
    off_mm = np.linalg.norm(ours[:3, 3] - there[:3, 3])
    cos = (np.trace(ours[:3, :3].T @ there[:3, :3]) - 1.0) / 2.0
    off_deg = np.degrees(np.arccos(np.clip(cos, -1.0, 1.0)))
    print(f"{off_mm:.2f} mm, {off_deg:.2f} degrees")
    assert off_mm < 2.0
    assert off_deg < 0.5
    assert found.lies == (there[2, 3] == 0.0)
    assert (found.anchor.family, found.anchor.size_mm) == (marker.family.name, marker.size_mm)
    assert found.anchor.marker in marker.middles_mm


def test_a_marker_of_another_size_is_refused_with_the_size_it_has(place):
    with pytest.raises(Refused, match=r"measures (79|80)\.[0-9] mm and not the 100 mm stated"):
        stated = dataclasses.replace(TAG, size_mm=100.0)
        sheet = printed(TAG.picture(112.0, 112.0, 5), 150.0, 100.0, 112.0)
        furnished = dataclasses.replace(place.room, sheets=(sheet,))
        anchor_pose(
            place.colour(room=furnished),
            stated,
            place.camera,
            place.plane,
            place.background,
            place.depths(furnished),
        )


def test_a_marker_without_depth_is_refused(place):
    blind = [np.zeros((576, 640), np.uint16)] * 3
    sheet = printed(TAG.picture(112.0, 112.0, 5), 150.0, 100.0, 112.0)
    picture = place.colour(room=dataclasses.replace(place.room, sheets=(sheet,)))
    with pytest.raises(Refused, match="no depth on the marker"):
        anchor_pose(picture, TAG, place.camera, place.plane, place.background, blind)
    # Another number is nobody's anchor.
    other = anchor("apriltag-36h11", 5, 80.0)
    with pytest.raises(Refused, match="marker 5 is not seen"):
        anchor_pose(picture, other, place.camera, place.plane, place.background, blind)
