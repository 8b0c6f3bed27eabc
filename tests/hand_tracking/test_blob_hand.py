"""A hand that the model does not find: its finger by the shape of what stands above the surface."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from halo_service.hand_tracking.blob_hand import CONFIDENCE, hand_from_blob
from halo_service.hand_tracking.region_tracker import UNFOUND_US, RegionTracker
from halo_service.hand_tracking.regions import find_regions
from halo_service.values import Frame, Hand, Side, Tracked

SHAPE = (576, 640)
SURFACE_MM = 500.0
FOCAL_PX = 500.0
VALID = np.ones(SHAPE, np.bool_)
BACKGROUND = np.full(SHAPE, SURFACE_MM, np.float32)
TIP_PX = (320, 240)


def heights(*parts: tuple[tuple[int, int], tuple[int, int], int, float]) -> np.ndarray:
    """Draw thick lines: from, to, breadth in px, height in mm. A pixel is a millimetre."""
    height = np.zeros(SHAPE, np.float32)
    for start, end, breadth, high_mm in parts:
        line = np.zeros(SHAPE, np.uint8)
        cv2.line(line, start, end, (1,), breadth)
        height = np.maximum(height, np.float32(high_mm) * line)
    return height


ARM = ((320, 620), (320, 420), 60, 60.0)
PALM = ((310, 400), (350, 400), 80, 50.0)
FINGER = ((320, 360), TIP_PX, 15, 12.0)
THUMB = ((300, 400), (240, 350), 18, 40.0)
FOLDED = ((350, 360), (350, 345), 18, 40.0)


def found(height_mm: np.ndarray) -> Hand | None:
    region = find_regions(height_mm, VALID, (), FOCAL_PX / SURFACE_MM)[0]
    return hand_from_blob(height_mm, BACKGROUND, VALID, region)


@pytest.mark.parametrize("others", [(), (THUMB,), (THUMB, FOLDED)])
def test_a_stretched_finger_of_a_hand_that_comes_in_is_found(others: tuple) -> None:
    hand = found(heights(ARM, PALM, FINGER, *others))
    assert hand is not None
    assert (hand.side, hand.confidence) == (Side.UNKNOWN, CONFIDENCE)
    assert math.dist(hand.landmarks_px[8], TIP_PX) < 12.0  # the end of the line is round
    root, tip = hand.landmarks_px[[5, 8]]
    assert math.degrees(math.atan2(tip[0] - root[0], root[1] - tip[1])) == pytest.approx(0, abs=8)


def test_a_blurred_edge_of_an_arm_is_no_finger() -> None:
    hand = found(heights(ARM, PALM, FINGER, ((354, 620), (354, 480), 5, 6.0)))
    assert hand is not None and math.dist(hand.landmarks_px[8], TIP_PX) < 12.0


@pytest.mark.parametrize(
    "parts",
    [
        (ARM, PALM),
        (PALM, FINGER),  # nothing comes in from outside: a pan with its handle
        (((200, 570), (440, 400), 150, 30.0),),  # a book over the edge
        (((320, 620), (320, 240), 20, 14.0),),  # a thick ruler: thin everywhere
    ],
    ids=["fist", "pan", "book", "ruler"],
)
def test_other_things_have_no_finger(parts: tuple) -> None:
    assert found(heights(*parts)) is None


class FindsNothing:
    """The hand model, where it finds no hand."""

    def find(self, _picture: np.ndarray, time_us: int) -> Tracked:
        return Tracked(time_us, ())

    def close(self) -> None:
        """There is nothing to free."""


@pytest.fixture
def blind(monkeypatch: pytest.MonkeyPatch) -> RegionTracker:
    """A tracker with a model that finds nothing."""
    monkeypatch.setattr(
        "halo_service.hand_tracking.region_tracker.HandTracker", lambda *_, **__: FindsNothing()
    )
    return RegionTracker(None, BACKGROUND, VALID, FOCAL_PX, 2)


def test_a_thing_that_lies_still_is_not_examined_in_every_frame(
    blind: RegionTracker, monkeypatch: pytest.MonkeyPatch
) -> None:
    times_us: list[int] = []
    monkeypatch.setattr(
        "halo_service.hand_tracking.region_tracker.hand_from_blob", lambda *_: times_us.append(0)
    )
    book = heights(((200, 570), (440, 400), 150, 30.0))
    depth, ir = (SURFACE_MM - book).astype(np.uint16), np.full(SHAPE, 800, np.uint16)
    for time_us in range(0, 5 * UNFOUND_US, 33_000):
        blind.detect(Frame(time_us, depth, ir))
    assert 3 <= len(times_us) <= 5


def test_the_tracker_reports_a_shape_only_where_the_model_finds_nothing_for_a_while(
    blind: RegionTracker,
) -> None:
    tracker = blind
    depth = (SURFACE_MM - heights(ARM, PALM, FINGER)).astype(np.uint16)
    ir = np.full(SHAPE, 800, np.uint16)
    counts = {
        time_us: len(tracker.detect(Frame(time_us, depth, ir)).hands)
        for time_us in range(0, 2 * UNFOUND_US, 33_000)
    }
    assert all(count == (time_us >= UNFOUND_US) for time_us, count in counts.items())
    empty = tracker.detect(Frame(10**6, BACKGROUND.astype(np.uint16), ir))
    assert empty.hands == ()
    again = tracker.detect(Frame(10**6 + 33_000, depth, ir))
    assert again.hands == ()
