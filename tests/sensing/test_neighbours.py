"""Other fingers of a hand are left out, also where landmarks are wrong or a finger hangs over."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from halo_service.sensing import SensingSettings
from halo_service.sensing.detections import Detection
from halo_service.sensing.finger_frame import FingerFrame
from halo_service.sensing.neighbours import without_others
from halo_service.sensing.outline import outline
from halo_service.sensing.segmentation import Segmentation, segment
from halo_service.values import Finger, Side

SHAPE = (576, 640)
TIP = (320, 300)
RADIUS_MM = 7.0
LOW_MM, HIGH_MM = 12.0, 50.0


def hand(apart: float) -> NDArray[np.float64]:
    """Fingers that point up the image side by side, the index finger's tip at `TIP`."""
    marks = np.full((21, 2), 500.0)
    for finger in Finger:
        x = TIP[0] + apart * (int(finger) - 1)
        for joint in range(4):
            marks[1 + 4 * int(finger) + joint] = x, TIP[1] + 75.0 - 25.0 * joint
    return marks


def detected(marks: NDArray[np.float64]) -> Detection:
    at = (float(TIP[0]), float(TIP[1]))
    joint = (at[0], at[1] + 25.0)
    return Detection(0, Side.RIGHT, Finger.INDEX, at, joint, 0.9, 1.0, True, marks, 1.0)


def away(x: float, y: float) -> NDArray[np.float32]:
    """Return how far each pixel is from a finger with this end, px; negative inside."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float32)
    across, ahead = columns - x, y - rows
    return np.hypot(np.maximum(ahead + RADIUS_MM, 0.0), across) - RADIUS_MM


def two_fingers(apart: float, longer: float) -> Segmentation:
    """An index finger near the surface, and a middle finger high above it."""
    excess = np.zeros(SHAPE, np.float32)
    excess[away(*TIP) < 0.0] = -LOW_MM
    excess[away(TIP[0] + apart, TIP[1] - longer) < 0.0] = -HIGH_MM
    return segment(excess, SensingSettings(), 8.0)


@pytest.mark.parametrize("moved", [(0.0, 0.0), (7.0, -12.0)])
def test_pixels_on_a_neighbours_bones_are_no_part_of_a_finger(moved: tuple[float, float]) -> None:
    everything = segment(np.full(SHAPE, -20.0, np.float32), SensingSettings(), 8.0)
    x, y = round(TIP[0] + moved[0]), round(TIP[1] + moved[1])
    own = without_others(everything, detected(hand(18.0)), moved)
    assert own.hand[y + 5 : y + 60, x - 5 : x + 5].all()
    assert not own.hand[y + 5 : y + 60, x + 13 : x + 23].any()
    assert own.free.sum() == 0


def test_a_window_outside_the_image_stays_empty() -> None:
    empty = np.zeros((0, 5), np.bool_)
    nothing = Segmentation(np.zeros((0, 5), np.float32), empty, empty, empty, empty)
    assert without_others(nothing, detected(hand(18.0))).hand.size == 0


def test_a_step_outweighs_joints_that_are_on_the_neighbour() -> None:
    """The model sees the last two joints 14 mm to the side, where the middle finger hangs."""
    marks = hand(16.0)
    marks[7:9, 0] += 14.0
    own = without_others(two_fingers(16.0, 15.0), detected(marks))
    middle = TIP[0] + 16
    assert not own.hand[TIP[1] : TIP[1] + 60, middle - 3 : middle + 3].any()
    assert own.share is not None
    assert float(own.share[TIP[1] : TIP[1] + 60, middle - 3 : middle + 3].max()) < 0.2


def test_under_a_neighbour_nothing_is_known() -> None:
    scene = two_fingers(9.0, 15.0)
    own = without_others(scene, detected(hand(9.0)))
    assert own.hidden is not None
    over = np.s_[TIP[1] : TIP[1] + 40, TIP[0] + 4 : TIP[0] + 8]
    assert own.hidden[over].all()
    assert not own.hand[over].any()
    assert not own.free[over].any()
    assert (own.excess_mm[over] == 0.0).all()
    shown = np.s_[TIP[1] + 5 : TIP[1] + 40, TIP[0] - 6 : TIP[0]]
    assert not own.hidden[shown].any()


def test_a_lower_neighbour_hides_nothing() -> None:
    excess = np.zeros(SHAPE, np.float32)
    excess[away(TIP[0] + 14.0, TIP[1] + 10.0) < 0.0] = -LOW_MM
    excess[away(*TIP) < 0.0] = -HIGH_MM
    own = without_others(segment(excess, SensingSettings(), 8.0), detected(hand(14.0)))
    assert own.hidden is not None
    assert not own.hidden[TIP[1] : TIP[1] + 40].any()


@pytest.mark.parametrize("apart", [8.0, 10.0, 14.0])
@pytest.mark.parametrize("off", [(0.0, 0.0), (4.0, -4.0), (3.0, 6.0)])
def test_a_half_hidden_finger_is_found(apart: float, off: tuple[float, float]) -> None:
    """Of the finger's 14 mm, 7 to 14 show next to the one above it."""
    own = without_others(two_fingers(apart, 15.0), detected(hand(apart)))
    depth = np.full(SHAPE, 500, np.uint16)
    guess = FingerFrame((TIP[0] + off[0], TIP[1] + off[1]), (0.0, -1.0), 1.0)
    found = outline(own, depth, guess, RADIUS_MM)
    assert found is not None
    assert math.dist(found.place.tip_px, TIP) < 5.0
