"""Pictures of the page show what was measured, and what is drawn on them lies in its place."""

from __future__ import annotations

import json
import struct
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from halo_service.app.page.pictures import (
    FARTHER_MM,
    NEARER_MM,
    STEP,
    Look,
    excess_grey,
    picture,
)
from halo_service.geometry.surface import from_view
from halo_service.profile import Background, Profile
from halo_service.values import Frame, TouchFrame
from halo_service.virtual.room import Room

CAMERA = Room().camera()
SHAPE = (CAMERA.depth.height, CAMERA.depth.width)
FLAT_MM = 500.0


def profile() -> Profile:
    surface = from_view(np.array([0.0, 0.0, 1.0]), FLAT_MM, width_mm=200.0, height_mm=100.0)
    mean = np.full(SHAPE, FLAT_MM, np.float32)
    background = Background(mean, np.full(SHAPE, 1.0, np.float32), np.full(SHAPE, True))
    return Profile("desk", CAMERA, surface, background, None, 1)


def look(depth: NDArray[np.uint16], known: Profile | None, colour: Any = None) -> Look:
    infrared = np.full(SHAPE, 300, np.uint16)
    frame = Frame(1, depth, infrared, colour)
    return Look(frame, TouchFrame(1, "table", 200.0, 100.0), CAMERA, known)


def opened(message: bytes | None) -> tuple[dict[str, Any], NDArray[np.uint8]]:
    assert message is not None
    (length,) = struct.unpack_from("<I", message)
    image = cv2.imdecode(np.frombuffer(message[4 + length :], np.uint8), cv2.IMREAD_COLOR)
    return json.loads(message[4 : 4 + length]), np.asarray(image, np.uint8)


@pytest.mark.parametrize(
    ("off_mm", "grey"),
    [(0.0, 128), (FARTHER_MM, 255), (90.0, 255), (-NEARER_MM, 1), (-300.0, 1), (16.0, 191)],
)
def test_grey_is_the_distance_from_the_surface(off_mm: float, grey: int) -> None:
    depth = np.full((2, 2), 500.0 + off_mm, np.uint16)
    mean = np.full((2, 2), 500.0, np.float32)
    assert (excess_grey(depth, mean, np.full((2, 2), True)) == grey).all()


def test_what_is_not_measured_is_black() -> None:
    depth = np.array([[0, 500]], np.uint16)
    mean = np.full((1, 2), 500.0, np.float32)
    assert excess_grey(depth, mean, np.array([[True, False]])).tolist() == [[0, 0]]


def test_a_block_on_the_table_gets_an_outline_where_it_is() -> None:
    depth = np.full(SHAPE, round(FLAT_MM), np.uint16)
    depth[200:300, 100:260] -= 60
    header, image = opened(picture("depth", look(depth, profile())))
    assert (header["width"], header["height"]) == (SHAPE[1] // STEP, SHAPE[0] // STEP)
    (outline,) = header["outlines"]
    low, high = np.min(outline, axis=0), np.max(outline, axis=0)
    assert np.abs(STEP * low - (100, 200)).max() <= STEP
    assert np.abs(STEP * high - (260, 300)).max() <= STEP
    assert image[125, 90, 0] < 80 < 110 < image[20, 160, 0]
    assert opened(picture("infrared", look(depth, profile())))[0]["outlines"] == [outline]
    lens = CAMERA.colour
    assert lens is not None
    colour = np.zeros((lens.height, lens.width, 3), np.uint8)
    header, _ = opened(picture("colour", look(depth, profile(), colour)))
    corners = CAMERA.depth.rays(np.array([[100.0, 200.0], [258.0, 298.0]])) * (FLAT_MM - 60.0)
    corners = corners @ CAMERA.colour_from_depth[:3, :3].T + CAMERA.colour_from_depth[:3, 3]
    seen = lens.project(corners) / (lens.width / header["width"])
    (moved,) = header["outlines"]
    for corner in seen:
        assert np.abs(np.array(moved) - corner).max(axis=1).min() < 2.0


def test_the_surface_is_drawn_where_the_lens_sees_it() -> None:
    depth = np.full(SHAPE, round(FLAT_MM), np.uint16)
    known = profile()
    header, _ = opened(picture("infrared", look(depth, known)))
    corners = np.array([[0.0, 0.0], [200.0, 0.0], [200.0, 100.0], [0.0, 100.0]])
    seen = known.surface.in_picture(corners, CAMERA.depth, np.eye(4)) / STEP
    drawn = np.array(header["surface"])
    for corner in seen:
        assert np.abs(drawn - corner).max(axis=1).min() < 0.1


def test_without_a_profile_depth_is_shown_as_it_is() -> None:
    depth = np.tile(np.linspace(400, 900, SHAPE[1]).astype(np.uint16), (SHAPE[0], 1))
    header, image = opened(picture("depth", look(depth, None)))
    assert 395 <= header["from_mm"] < header["to_mm"] <= 905
    assert image[10, 5, 0] > image[10, 300, 0]
    assert "surface" not in header


def test_the_camera_s_own_jpeg_goes_out_as_it_came() -> None:
    depth = np.zeros(SHAPE, np.uint16)
    message = picture("colour", look(depth, None, b"\xff\xd8 a JPEG"))
    assert message is not None and message.endswith(b"\xff\xd8 a JPEG")
    assert picture("colour", look(depth, None)) is None
