"""Sheets, cards and projected pictures lie in the frames where the room says they are."""

import dataclasses

import cv2
import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.virtual.projector import Projector
from halo_service.virtual.props import printed, standing
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
SIDE_MM, EDGE_MM = 60.0, 10.0
PER_MM = 5
ROOM = Room(camera_height_mm=600.0, camera_pitch_deg=10.0, camera_yaw_deg=-8.0)


def marker(number: int = 7):
    """A marker with its white edge, 5 pixels a mm."""
    side, edge = round(SIDE_MM * PER_MM), round(EDGE_MM * PER_MM)
    black = cv2.aruco.generateImageMarker(DICTIONARY, number, side)
    return cv2.copyMakeBorder(black, edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=255)


def found(picture) -> dict[int, np.ndarray]:
    how = cv2.aruco.DetectorParameters()
    how.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    corners, ids, _ = cv2.aruco.ArucoDetector(DICTIONARY, how).detectMarkers(picture)
    return {} if ids is None else {int(i): c[0] for i, c in zip(ids[:, 0], corners, strict=True)}


def in_colour(sensor: Sensor, points: np.ndarray) -> np.ndarray:
    """Pixels of the colour lens that see points of the surface's frame."""
    turn = sensor.camera.colour_from_depth
    seen = sensor.surface.to_camera(points) @ turn[:3, :3].T + turn[:3, 3]
    return sensor.camera.colour.project(seen)


def corners_of(surface_from_sheet: np.ndarray) -> np.ndarray:
    half = SIDE_MM / 2.0
    square = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    flat = np.column_stack([square, np.zeros(4)])
    return flat @ surface_from_sheet[:3, :3].T + surface_from_sheet[:3, 3]


def turned(x_mm: float, y_mm: float, turn_deg: float, tilt_deg: float = 0.0, z_mm: float = 0.0):
    turn, tilt = np.radians(turn_deg), np.radians(tilt_deg)
    about_z = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    about_x = np.array(
        [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
    )
    pose = np.eye(4)
    pose[:3, :3] = about_z @ about_x
    pose[:3, 3] = (x_mm, y_mm, z_mm)
    return pose


@pytest.mark.parametrize(
    ("x_mm", "y_mm", "turn_deg"), [(150, 100, 0), (60, 40, 25), (240, 150, -70)]
)
def test_a_printed_sheet_is_seen_where_it_lies(x_mm, y_mm, turn_deg):
    width_mm = SIDE_MM + 2.0 * EDGE_MM
    sheet = printed(marker(), x_mm, y_mm, width_mm, turn_deg)
    sensor = Sensor(dataclasses.replace(ROOM, sheets=(sheet,)))
    frame = sensor.frame(1)
    truth = corners_of(turned(x_mm, y_mm, turn_deg))
    off = found(frame.colour)[7] - in_colour(sensor, truth)
    assert np.linalg.norm(off, axis=1).max() < 0.5
    # Toner is black in infrared too: the depth camera's picture shows the same marker.
    infrared = np.clip(frame.ir / 24.0, 0, 255).astype(np.uint8)
    off = found(infrared)[7] - sensor.camera.depth.project(sensor.surface.to_camera(truth))
    assert np.linalg.norm(off, axis=1).max() < 0.6


@pytest.mark.parametrize("tilt_deg", [0.0, 20.0])
def test_a_standing_card_is_seen_where_it_stands(tilt_deg):
    pose = turned(120.0, 90.0, 15.0, tilt_deg, z_mm=-60.0)
    sensor = Sensor(ROOM)
    frame = sensor.frame(1, things=[standing(marker(), SIDE_MM + 2.0 * EDGE_MM, pose)])
    truth = corners_of(pose)
    off = found(frame.colour)[7] - in_colour(sensor, truth)
    assert np.linalg.norm(off, axis=1).max() < 0.5
    # And depth sees it stand there.
    middle = sensor.surface.to_camera(pose[None, :3, 3])
    x, y = np.rint(sensor.camera.depth.project(middle)[0]).astype(int)
    assert abs(np.median(frame.depth[y - 2 : y + 3, x - 2 : x + 3]) - middle[0, 2]) < 5.0


def test_the_projector_shows_a_picture_until_it_gets_another():
    # Exposed as long as the room light asks for, projected white would run over the edges.
    room = dataclasses.replace(ROOM, light=0.5, exposure_ms=5.0)
    sensor = Sensor(room)
    dark = sensor.frame(1).colour
    picture = np.full((room.projector.height_px, room.projector.width_px, 3), 255, np.uint8)
    picture[200:500, 300:600] = cv2.cvtColor(
        cv2.aruco.generateImageMarker(DICTIONARY, 3, 300), cv2.COLOR_GRAY2BGR
    )
    sensor.show(picture)
    lit = sensor.frame(1).colour
    px = np.array([(300, 200), (600, 200), (600, 500), (300, 500)], float)
    back = np.linalg.inv(room.projector.projector_from_surface())
    mm = np.column_stack([px, np.ones(4)]) @ back.T
    mm = mm / mm[:, 2:]
    truth = in_colour(sensor, np.column_stack([mm[:, :2], np.zeros(4)]))
    assert np.linalg.norm(found(lit)[3] - truth, axis=1).max() < 0.5
    sensor.show(None)
    assert np.array_equal(sensor.frame(1).colour, dark)


def test_what_is_projected_stays_when_the_room_is_furnished():
    sensor = Sensor(ROOM)
    sensor.show(np.full((800, 1280, 3), 255, np.uint8))
    before = sensor.frame(1)
    sensor.furnish(dataclasses.replace(ROOM, sheets=(printed(marker(), 150.0, 100.0, 80.0),)))
    after = sensor.frame(1)
    assert np.median(after.colour) == np.median(before.colour)
    assert 7 in found(after.colour)


def test_a_mirrored_projector_turns_its_homography_over():
    plain, mirrored = Projector(), Projector(mirrored=True)
    there = np.array([[80.0, 60.0, 0.0]])
    width = plain.width_px
    (x, y), (x_mirrored, y_mirrored) = plain.pixels(there)[0], mirrored.pixels(there)[0]
    assert (x_mirrored, y_mirrored) == pytest.approx((width - x, y), abs=1e-3)
    assert np.linalg.det(plain.projector_from_surface()) > 0.0
    assert np.linalg.det(mirrored.projector_from_surface()) < 0.0


def test_a_camera_out_of_focus_blurs_and_a_long_exposure_whitens():
    sheet = printed(marker(), 150.0, 100.0, 80.0)
    plain = dataclasses.replace(ROOM, noise=0.0, sheets=(sheet,))
    sharp = Sensor(plain).frame(1).colour
    blurred = Sensor(dataclasses.replace(plain, blur_px=6.0)).frame(1).colour
    assert cv2.Laplacian(blurred, cv2.CV_64F).var() < 0.5 * cv2.Laplacian(sharp, cv2.CV_64F).var()
    bright = dataclasses.replace(plain, light=4.0)
    assert 7 in found(Sensor(bright).frame(1).colour)
    white = Sensor(dataclasses.replace(bright, exposure_ms=33.0)).frame(1).colour
    assert np.median(white) == 255
    assert not found(white)


def test_a_sheet_can_be_asked_for_by_a_file(tmp_path):
    path = tmp_path / "marker.png"
    cv2.imwrite(str(path), marker())
    (sheet,) = parse_sim_url(f"sim:idle?sheets={path}@150,100,80,12").room.sheets
    assert (sheet.x_mm, sheet.y_mm, sheet.width_mm, sheet.turn_deg) == (150.0, 100.0, 80.0, 12.0)
    assert sheet.height_mm == pytest.approx(80.0)
    for bad, why in (
        (f"{path}@here", "lies at 'here'"),
        ("/nowhere.png@1,2,3", "finds no picture"),
    ):
        with pytest.raises(UserError, match=why):
            parse_sim_url(f"sim:idle?sheets={bad}")
