"""The end of a finger is found by contrast, to a fraction of a pixel."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from halo_service.sensing.finger_frame import FingerFrame
from halo_service.sensing.outline import Outline
from halo_service.sensing.outline import outline as outline_of
from halo_service.sensing.segmentation import segment
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.silhouette import stands_out

RADIUS_PX = 7.0
SETTINGS = SensingSettings()
END = (320.0, 288.0)
TIMES = 8
"""Drawn so many times larger, then averaged: edges lie between pixels as a camera sees them."""


def finger(
    yaw_deg: float, inside_mm: float, dent_mm: float, noise_mm: float = 0.0, end: float = 0.0
) -> np.ndarray:
    """Draw the excess around a round-ended finger that rises from its end on, within a dent."""
    rows, columns = np.mgrid[: 128 * TIMES, : 128 * TIMES] / TIMES - 64.0 + 0.5 / TIMES
    yaw = math.radians(yaw_deg)
    ahead = columns * math.sin(yaw) - rows * math.cos(yaw) - end
    across = columns * math.cos(yaw) + rows * math.sin(yaw)
    away = np.hypot(np.maximum(ahead + RADIUS_PX, 0.0), across)
    dent = dent_mm * np.exp(-((np.hypot(ahead + RADIUS_PX, across) / 13.0) ** 3))
    excess = np.where(away < RADIUS_PX, inside_mm + 1.2 * np.minimum(ahead, 0.0), dent)
    small = cv2.resize(excess.astype(np.float32), (128, 128), interpolation=cv2.INTER_AREA)
    picture = np.zeros((576, 640), np.float32)
    x, y = round(END[0]), round(END[1])
    picture[y - 64 : y + 64, x - 64 : x + 64] = small
    if noise_mm:
        picture += np.random.default_rng(1).normal(0.0, noise_mm, picture.shape).astype(np.float32)
    return picture


def outline(
    picture: np.ndarray,
    depth: np.ndarray,
    guess: tuple[float, float],
    direction: tuple[float, float],
    radius_px: float,
) -> Outline | None:
    return outline_of(
        segment(picture, SETTINGS, 8.0), depth, FingerFrame(guess, direction, 1.0), radius_px
    )


MEASURED = np.full((576, 640), 500, np.uint16)
CASES = {
    "high above the surface": (-30.0, 0.0, 0.0),
    "low, in a shallow dent": (-12.0, 12.0, 0.0),
    "pressing: its end reads farther than the surface": (6.0, 26.0, 0.0),
    "pressing where the halo is strong": (12.0, 45.0, 0.0),
    "pressing, at twice a camera's noise": (6.0, 26.0, 2.0),
}


@pytest.mark.parametrize(("inside_mm", "dent_mm", "noise_mm"), CASES.values(), ids=CASES.keys())
@pytest.mark.parametrize("yaw_deg", [-35.0, 0.0, 20.0])
@pytest.mark.parametrize("off", [(0.0, 6.0), (-4.0, -5.0), (6.0, 0.0)])
def test_the_end_is_where_the_finger_stands_out(
    yaw_deg: float, off: tuple[float, float], inside_mm: float, dent_mm: float, noise_mm: float
) -> None:
    picture = finger(yaw_deg, inside_mm, dent_mm, noise_mm)
    yaw = math.radians(yaw_deg + 15.0)  # the landmarks' direction is as far off as it gets
    guess = (END[0] + off[0], END[1] + off[1])
    found = outline(picture, MEASURED, guess, (math.sin(yaw), -math.cos(yaw)), RADIUS_PX)
    assert found is not None
    assert found.clear
    # Pixels are counted from their centres: the drawing's middle lies half a pixel up and left.
    assert math.dist(found.place.tip_px, (END[0] - 0.5, END[1] - 0.5)) < 1.0
    turned = math.degrees(math.atan2(found.place.direction[0], -found.place.direction[1])) - yaw_deg
    assert abs(turned) < 6.0
    assert found.width_mm == pytest.approx(2.0 * RADIUS_PX, abs=1.0)


@pytest.mark.parametrize("ahead_px", [0.0, 0.25, 0.5, 0.75])
def test_a_part_of_a_pixel_counts(ahead_px: float) -> None:
    found = outline(finger(0.0, 6.0, 26.0, 0.0, ahead_px), MEASURED, END, (0.0, -1.0), RADIUS_PX)
    assert found is not None
    assert found.place.tip_px[1] == pytest.approx(END[1] - 0.5 - ahead_px, abs=0.35)


def test_an_outline_without_depth_is_bridged() -> None:
    picture, depth = finger(0.0, -30.0, 0.0), MEASURED.copy()
    mask = (picture < -4.0).astype(np.uint8)
    edge = cv2.dilate(mask, np.ones((3, 3))) != cv2.erode(mask, np.ones((3, 3)))
    lost = edge & (np.random.default_rng(1).random(edge.shape) < 0.7)
    depth[lost], picture[lost] = 0, 0.0
    found = outline(picture, depth, END, (0.0, -1.0), RADIUS_PX)
    assert found is not None
    assert math.dist(found.place.tip_px, (END[0] - 0.5, END[1] - 0.5)) < 1.5


def test_a_neighbour_does_not_turn_the_finger() -> None:
    picture = finger(0.0, 6.0, 26.0)
    picture[300:360, 332:350] = -60.0  # a folded finger next to it, higher up
    found = outline(picture, MEASURED, (END[0], END[1] + 5.0), (0.26, -0.97), RADIUS_PX)
    assert found is not None
    assert math.dist(found.place.tip_px, (END[0] - 0.5, END[1] - 0.5)) < 1.5


@pytest.mark.parametrize("behind_px", [12, 14])
@pytest.mark.parametrize("columns", [(283, 315), (325, 357)], ids=["left", "right"])
def test_knuckles_that_adjoin_the_finger_do_not_draw_it_over(
    columns: tuple[int, int], behind_px: int
) -> None:
    picture = finger(0.0, 6.0, 26.0)
    picture[288 + behind_px : 345, slice(*columns)] = -60.0
    found = outline(picture, MEASURED, END, (0.0, -1.0), RADIUS_PX)
    assert found is not None
    assert math.dist(found.place.tip_px, (END[0] - 0.5, END[1] - 0.5)) < 1.0
    assert found.place.direction == (0.0, -1.0)


def test_plain_noise_does_not_stand_out() -> None:
    noise = np.random.default_rng(1).normal(0.0, 2.0, (576, 640)).astype(np.float32)
    assert np.count_nonzero(stands_out(noise, 1.0)) < 5


@pytest.mark.parametrize("guess", [(320.0, 288.0), (-200.0, 288.0), (700.0, 900.0)])
def test_where_no_finger_is_there_is_no_outline(guess: tuple[float, float]) -> None:
    empty = np.zeros((576, 640), np.float32)
    assert outline(empty, MEASURED, guess, (0.0, -1.0), RADIUS_PX) is None
