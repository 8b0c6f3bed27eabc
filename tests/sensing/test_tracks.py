"""Fingers keep their ids, whatever the tracker calls them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halo_service.sensing.association import associate
from halo_service.sensing.detections import Detection
from halo_service.sensing.tracks import Past, Track, claim, is_there, predict
from halo_service.values import Finger, Fingertip, Side

FRAME_US = 33_333


def detection(
    x: float, n: int = 0, side: Side = Side.RIGHT, finger: Finger = Finger.INDEX
) -> Detection:
    return Detection(
        n * FRAME_US, side, finger, (x, 300.0), (x, 320.0), 0.9, 1.0, True, np.zeros((21, 2))
    )


def live(*xs: float, side: Side = Side.RIGHT) -> tuple[Track, ...]:
    """Fingers that have been there for ten frames, up to frame 10."""
    fingers = associate((), tuple(detection(x, 0, side) for x in xs), 1)
    for n in range(1, 11):
        fingers = tuple(
            replace(finger, path=(*finger.path, Past(n * FRAME_US, (x, 300.0)))[-8:])
            for finger, x in zip(fingers, xs, strict=True)
        )
        fingers = associate(fingers, tuple(detection(x, n, side) for x in xs), 9)
    return fingers


@pytest.mark.parametrize(
    ("seen", "ids"),
    [
        ((detection(100, 10), detection(300, 10)), [1, 2]),
        ((detection(320, 10), detection(110, 10)), [1, 2]),
        ((detection(100, 10, Side.LEFT), detection(300, 10, Side.LEFT)), [1, 2]),
        ((), [1, 2]),
        ((detection(300, 10),), [1, 2]),
        ((detection(100, 10), detection(300, 10), detection(200, 10, Side.LEFT)), [1, 2, 9]),
        ((detection(104, 10, finger=Finger.MIDDLE),), [1, 2]),
        ((detection(120, 10, finger=Finger.MIDDLE),), [1, 2, 9]),
    ],
    ids=[
        "both",
        "out of order",
        "sides flipped",
        "none",
        "one lost",
        "a third",
        "the same finger by another name",
        "its neighbour",
    ],
)
def test_ids_stay(seen: tuple[Detection, ...], ids: list[int]) -> None:
    assert [finger.id for finger in associate(live(100, 300), seen, 9)] == ids


def test_a_hand_is_the_side_that_it_is_called_most() -> None:
    fingers = live(100)
    for n in range(11, 15):
        fingers = associate(fingers, (detection(100, n, Side.LEFT),), 9)
        assert fingers[0].side is Side.RIGHT
    for n in range(15, 25):
        fingers = associate(fingers, (detection(100, n, Side.LEFT),), 9)
    assert fingers[0].side is Side.LEFT


def test_there_are_as_many_slots_as_fingers() -> None:
    fingers = associate((), tuple(detection(40.0 * n) for n in range(12)), 1)
    assert [finger.slot for finger in fingers] == list(range(10))


def test_a_finger_is_predicted_at_its_last_speed() -> None:
    finger = live(100)[0]
    finger = replace(finger, path=(*finger.path, Past(11 * FRAME_US, (106.0, 300.0))))
    assert predict(finger, 12 * FRAME_US).place.tip_px == pytest.approx((112.0, 300.0), abs=0.01)


@pytest.mark.parametrize(("off_px", "contradicted"), [(10.0, 0), (29.0, 0), (50.0, 1)])
def test_a_detection_far_off_its_path_contradicts_a_finger(
    off_px: float, contradicted: int
) -> None:
    finger = associate(live(100), (detection(100 + off_px, 11),), 9)[0]
    assert finger.contradicted == contradicted


@pytest.mark.parametrize(("age", "claimed"), [(0, True), (4, True), (6, False)])
def test_an_old_detection_gives_no_place(age: int, claimed: bool) -> None:
    finger = live(100)[0]
    assert (claim(finger, (10 + age) * FRAME_US) is not None) is claimed


@pytest.mark.parametrize(
    ("speed_px", "late", "off_px", "there"),
    [
        (0.0, 1, 10.0, True),
        (0.0, 1, 15.0, False),
        (15.0, 1, 20.0, True),
        (15.0, 1, 30.0, False),
        (15.0, 3, 50.0, True),
    ],
    ids=["near", "a knuckle", "ahead, for it moves", "too far ahead", "of a slow tracker"],
)
def test_a_tip_far_from_the_detection_is_another_finger(
    speed_px: float, late: int, off_px: float, there: bool
) -> None:
    finger = live(100)[0]
    path = tuple(Past(n * FRAME_US, (100.0 + speed_px * (n - 8), 300.0)) for n in range(8, 12))
    finger = replace(finger, path=path, detection=detection(path[-late].tip_px[0], 12 - late))
    claimed, expected = claim(finger, 12 * FRAME_US), predict(finger, 12 * FRAME_US)
    assert claimed is not None
    tip_px = (claimed.place.tip_px[0] + off_px, 300.0)
    tip = Fingertip(
        Side.RIGHT, Finger.INDEX, tip_px, (100.0, 320.0), (0, 0), (0, 0, 500), 14.0, 45.0, 0.0, 1.0
    )
    assert is_there(finger, claimed, expected, tip) is there


def test_two_pointers_on_one_finger_become_one() -> None:
    one, other = live(100, 300)
    there = replace(other, path=(*other.path, Past(11 * FRAME_US, (103.0, 305.0))))
    found = associate((one, there), (detection(100, 11),), 9)
    assert [finger.id for finger in found] == [1]


def test_a_finger_that_is_detected_elsewhere_for_long_ends() -> None:
    fingers = live(100)
    assert [finger.id for finger in associate(fingers, (detection(400, 12),), 9)] == [1, 9]
    assert [finger.id for finger in associate(fingers, (detection(400, 30),), 9)] == [9]
