"""A printed marker's pose, lying on the surface or standing over it."""

import dataclasses

import numpy as np
import pytest

from halo_calibration.boards.board import anchor
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.anchor import anchor_pose
from halo_service.virtual.props import printed
from tests.placed import Place, anchored, pose_error, posed, room

TAG = anchor("apriltag-36h11", 0, 80.0)
ARUCO = anchor("aruco-4x4", 70, 60.0)


CAMERAS = [(450.0, 0.0, "720P"), (700.0, 15.0, "1080P"), (1000.0, -10.0, "720P")]


@pytest.fixture(scope="module", params=CAMERAS, ids=lambda case: f"{case[0]:.0f} mm")
def place(request):
    height_mm, pitch_deg, resolution = request.param
    return Place(room(height_mm, pitch_deg, 5.0, material="wood", light=0.8), resolution)


@pytest.mark.parametrize(
    ("marker", "there"),
    [
        (TAG, posed(60.0, 50.0, 0.0, 20.0)),
        (ARUCO, posed(200.0, 120.0, 0.0, -160.0)),
        (TAG, posed(240.0, 150.0, -40.0, -30.0)),
        (TAG, posed(100.0, 140.0, -50.0, 70.0, 20.0, -10.0)),
        (ARUCO, posed(150.0, 60.0, -30.0, 170.0, -8.0, 3.0)),
    ],
    ids=["tag lies", "aruco lies", "tag on a box", "tag leans", "aruco leans"],
)
def test_the_anchor_is_found(place, marker, there):
    found = anchored(place, marker, there)
    off_mm, off_deg = pose_error(found, there)
    print(f"{off_mm:.2f} mm, {off_deg:.2f} degrees")
    assert off_mm < 2.0
    assert off_deg < 0.5
    assert found.lies == (there[2, 3] == 0.0)
    assert (found.anchor.family, found.anchor.size_mm) == (marker.family.name, marker.size_mm)
    assert found.anchor.marker in marker.middles_mm


def test_a_marker_of_another_size_is_refused_with_the_size_it_has(place):
    with pytest.raises(
        CalibrationError, match=r"measures (79|80)\.[0-9] mm and not the 100 mm given"
    ):
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
    with pytest.raises(CalibrationError, match="no depth on the marker"):
        anchor_pose(picture, TAG, place.camera, place.plane, place.background, blind)
    # Another number is not the anchor.
    other = anchor("apriltag-36h11", 5, 80.0)
    with pytest.raises(CalibrationError, match="marker 5 is not seen"):
        anchor_pose(picture, other, place.camera, place.plane, place.background, blind)
