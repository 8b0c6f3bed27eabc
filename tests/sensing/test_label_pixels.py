"""Each pixel is the nearest finger's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halo_service.sensing.finger_frame import FingerFrame
from halo_service.sensing.label_pixels import (
    Prediction,
    is_finger,
    label_pixels,
    pixels_of,
    strip_end,
)
from halo_service.sensing.segmentation import Segmentation, segment
from halo_service.sensing.settings import SensingSettings

UP = (0.0, -1.0)
SHAPE = (576, 640)


def expected(x: float, y: float, top_mm: float = math.nan) -> Prediction:
    return Prediction(FingerFrame((x, y), UP, 1.0), top_mm)


def fingers(*tips: tuple[int, int], breadth: int = 14, height_mm: float = 20.0) -> np.ndarray:
    """Draw fingers that point up the image, and a dent everywhere else."""
    excess = np.full(SHAPE, 10.0, np.float32)
    for x, y in tips:
        excess[y : y + 80, x - breadth // 2 : x + breadth // 2] = -height_mm
    return excess


def in_image(own: Segmentation) -> Segmentation:
    """Put a finger's part of the image back where it was cut."""
    around = (
        (own.top, SHAPE[0] - own.top - own.hand.shape[0]),
        (own.left, SHAPE[1] - own.left - own.hand.shape[1]),
    )
    parts = (own.excess_mm, own.halo, own.hand, own.free, own.solid)
    masks = (np.pad(each, around) for each in parts)
    return Segmentation(*masks)


@pytest.mark.parametrize("apart", [16, 24, 60])
def test_neighbours_share_hand_and_halo(apart: int) -> None:
    excess = fingers((300, 300), (300 + apart, 310))
    segmentation = segment(excess, SensingSettings(), 8.0)
    places = [expected(300, 300), expected(300 + apart, 310)]
    labels = label_pixels(places, segmentation)
    left, right = (
        in_image(pixels_of(segmentation, labels, n, place)) for n, place in enumerate(places)
    )
    assert not (left.halo & right.halo).any()
    assert not (left.hand & right.hand).any()
    assert left.hand[320, 294:306].all()
    assert right.hand[320, 300 + apart - 5 : 300 + apart + 5].all()
    assert left.halo[295, 300] and right.halo[305, 300 + apart]


def test_a_finger_predicted_too_far_out_gets_no_pixel_of_its_neighbour() -> None:
    segmentation = segment(fingers((300, 330), (316, 300)), SensingSettings(), 8.0)
    places = [expected(300, 318), expected(316, 300)]
    own = in_image(pixels_of(segmentation, label_pixels(places, segmentation), 0, places[0]))
    assert not own.hand[300:325].any()


def test_what_is_far_above_a_fingertip_is_another_part_of_the_hand() -> None:
    excess = fingers((300, 300))
    excess[280:320, 310:330] = -60.0
    segmentation = segment(excess, SensingSettings(), 8.0)
    place = expected(300, 300, top_mm=20.0)
    own = in_image(pixels_of(segmentation, label_pixels([place], segmentation), 0, place))
    assert not own.hand[280:300].any()
    assert own.hand[302, 300]


@pytest.mark.parametrize("off", [-40, -20, 0, 15])
def test_a_tip_that_went_farther_along_its_line_is_found(off: int) -> None:
    segmentation = segment(fingers((300, 300)), SensingSettings(), 8.0)
    assert strip_end(segmentation, expected(300, 300 + off).place).tip_px[1] == pytest.approx(
        300.0, abs=3.0
    )


def test_where_no_hand_is_the_tip_stays_where_it_was_expected() -> None:
    empty = segment(np.zeros(SHAPE, np.float32), SensingSettings(), 8.0)
    assert strip_end(empty, expected(-20, 900).place).tip_px == (-20, 900)


@pytest.mark.parametrize(
    ("breadth", "finger"), [(0, False), (2, False), (8, True), (14, True), (20, True), (28, False)]
)
def test_a_finger_is_as_broad_as_a_finger(breadth: int, finger: bool) -> None:
    segmentation = segment(fingers((300, 300), breadth=breadth), SensingSettings(), 8.0)
    assert is_finger(segmentation, expected(300, 300).place) is finger


def test_outside_the_image_is_no_finger() -> None:
    hand = segment(np.full(SHAPE, -20.0, np.float32), SensingSettings(), 8.0)
    assert not is_finger(hand, expected(-50, 700).place)
