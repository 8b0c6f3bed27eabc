"""Where hands are looked for, on drawn heights: shapes of which everything is known."""

import math

import cv2
import numpy as np
import pytest

from halo_service.hand_tracking.picture import SIZE_PX, in_image, region_picture
from halo_service.hand_tracking.regions import REGION_MM, Region, find_regions, region_of_hand
from halo_service.values import Hand, Side

SHAPE = (576, 640)
EVERYWHERE = np.ones(SHAPE, bool)


def arm(*points: tuple[int, int], width_px: int = 60, height_mm: float = 60.0) -> np.ndarray:
    """Draw the heights of a thick line."""
    heights = np.zeros(SHAPE, np.float32)
    cv2.polylines(heights, [np.array(points, np.int32)], False, (height_mm,), width_px)
    return heights


def hand_at(x: float, y: float) -> Hand:
    """Return landmarks of a hand that points up the image, its wrist 100 px below (x, y)."""
    rows = np.linspace(0.0, 100.0, 21)[::-1]
    columns = 30.0 * np.sin(np.arange(21))
    return Hand(Side.RIGHT, np.column_stack([x + columns, y + rows]), 0.9)


@pytest.mark.parametrize(
    ("points", "near"),
    [
        (((300, 575), (300, 250)), (300, 310)),
        (((300, 0), (300, 320)), (300, 260)),
        (((0, 280), (330, 280)), (270, 280)),
        (((639, 280), (300, 280)), (360, 280)),
        (((639, 575), (400, 330)), (450, 380)),
    ],
)
def test_the_hand_is_at_the_far_end_of_what_comes_in(points, near) -> None:
    (region,) = find_regions(arm(*points), EVERYWHERE, (), 1.0)
    assert math.dist((region.x_px, region.y_px), near) < 40.0
    assert region.side_px == REGION_MM


def test_an_arm_that_comes_in_where_the_camera_stops_measuring_is_no_different() -> None:
    measured = np.zeros(SHAPE, np.uint8)
    cv2.circle(measured, (320, 288), 250, (1,), -1)
    heights = arm((320, 575), (320, 250)) * measured
    (region,) = find_regions(heights, measured > 0, (), 1.0)
    assert math.dist((region.x_px, region.y_px), (320, 310)) < 40.0


@pytest.mark.parametrize("px_per_mm", [0.5, 1.0, 1.5])
def test_sizes_are_of_the_surface_and_not_of_the_image(px_per_mm: float) -> None:
    small = arm((300, 300), (300, 300), width_px=round(24 * px_per_mm))  # a disc of 24 mm
    large = arm((300, 300), (300, 300 + round(80 * px_per_mm)), width_px=round(50 * px_per_mm))
    assert find_regions(small, EVERYWHERE, (), px_per_mm) == ()
    (region,) = find_regions(large, EVERYWHERE, (), px_per_mm)
    assert region.side_px == pytest.approx(REGION_MM * px_per_mm)


def test_noise_and_low_things_are_no_region() -> None:
    noise = np.random.default_rng(1).normal(0.0, 4.0, SHAPE).astype(np.float32)
    assert find_regions(noise, EVERYWHERE, (), 1.0) == ()
    assert find_regions(arm((300, 575), (300, 250), height_mm=5.0), EVERYWHERE, (), 1.0) == ()


def test_the_larger_blob_comes_first() -> None:
    both = np.maximum(arm((150, 575), (150, 450)), arm((500, 575), (500, 200)))
    first, second = find_regions(both, EVERYWHERE, (), 1.0)
    assert first.x_px > 400 > second.x_px


def test_a_known_hand_and_its_arm_are_not_proposed_again() -> None:
    assert find_regions(arm((300, 575), (300, 300)), EVERYWHERE, (hand_at(300, 280),), 1.0) == ()


def test_an_arm_that_passes_behind_a_known_hand_is_still_proposed() -> None:
    both = np.maximum(arm((300, 575), (300, 300)), arm((639, 500), (400, 500), width_px=40))
    (region,) = find_regions(both, EVERYWHERE, (hand_at(300, 280),), 1.0)
    assert region.x_px > 380


@pytest.mark.parametrize("middle", [(300.0, 280.0), (10.0, 280.0), (630.0, 570.0)])
def test_places_in_a_picture_are_places_in_the_image(middle: tuple[float, float]) -> None:
    region = Region(*middle, 400.0)
    ir = np.zeros(SHAPE, np.uint16)
    x, y = (round(min(max(each, 5.0), 560.0)) for each in middle)
    heights = arm((x, y), (x, y), width_px=90)
    ir[y - 2 : y + 3, x - 2 : x + 3] = 40_000  # one bright spot
    picture = region_picture(heights, ir, region)
    assert picture is not None and picture.shape == (SIZE_PX, SIZE_PX)
    row, column = np.unravel_index(int(picture.argmax()), picture.shape)
    found = in_image(np.array([[column, row]], np.float64), region)[0]
    assert math.dist(found, (x, y)) < 4.0


def test_nothing_above_the_surface_is_no_picture() -> None:
    flat = np.zeros(SHAPE, np.float32)
    assert region_picture(flat, np.full(SHAPE, 900, np.uint16), Region(300, 300, 400)) is None


def test_hidden_hands_are_dark() -> None:
    heights, ir = arm((300, 575), (300, 250)), np.full(SHAPE, 900, np.uint16)
    hand = hand_at(300, 280)
    region = region_of_hand(hand, 1.0)
    shown, hidden = (region_picture(heights, ir, region, each) for each in ((), (hand,)))
    assert shown is not None and hidden is not None
    middle = SIZE_PX // 2
    assert shown[middle, middle] > 50 > hidden[middle, middle]
