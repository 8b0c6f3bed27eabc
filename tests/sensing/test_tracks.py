"""Fingers keep their ids, whatever the tracker calls them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halo_service.profile import Background
from halo_service.sensing.association import associate, best_pairs, load_solver
from halo_service.sensing.detections import Detection
from halo_service.sensing.registration import HeightMap, height_map
from halo_service.sensing.tracks import (
    Phase,
    Track,
    carry,
    claim,
    is_there,
    measured,
    predict,
)
from halo_service.values import Finger, Fingertip, Side

FRAME_US = 33_333


def detection(
    x: float, n: int = 0, side: Side = Side.RIGHT, finger: Finger = Finger.INDEX
) -> Detection:
    return Detection(
        n * FRAME_US, side, finger, (x, 300.0), (x, 320.0), 0.9, 1.0, True, np.zeros((21, 2)),
        1.0,
    )  # fmt: skip


def tip(x: float, y: float = 300.0) -> Fingertip:
    """Return a fingertip in the image, where a pixel is a millimetre."""
    return Fingertip(
        Side.RIGHT, Finger.INDEX, (x, y), (x, y + 20.0), (0, 0), (0, 0, 500), 14.0, 45.0, 0.0, 1.0,
        16.0,
    )  # fmt: skip


def measure(finger: Track, n: int, x: float, y: float = 300.0) -> Track:
    return measured(finger, n * FRAME_US, tip(x, y), True, 1.0)


def live(*xs: float, side: Side = Side.RIGHT) -> tuple[Track, ...]:
    """Fingers that have been there for ten frames, up to frame 10."""
    fingers = associate((), tuple(detection(x, 0, side) for x in xs), 1)
    for n in range(1, 11):
        fingers = tuple(measure(each, n, x) for each, x in zip(fingers, xs, strict=True))
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


def test_detections_that_are_off_the_same_way_are_assigned_together() -> None:
    """The nearest pair alone would leave the other two far apart."""
    seen = associate(live(100, 130), (detection(122, 11), detection(152, 11)), 9)
    assert [finger.detection.place_mm[0] for finger in seen] == [122, 152]


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
    for n in range(11, 15):
        finger = measure(finger, n, 100.0 + 6.0 * (n - 10))
    place = predict(finger, 15 * FRAME_US, 1.0).place
    assert place.tip_px == pytest.approx((130.0, 300.0), abs=0.5)


def test_a_late_detection_corrects_a_finger_that_no_frame_shows_at_its_own_time() -> None:
    finger = live(100)[0]
    for n in (11, 12):
        finger = measure(finger, n, 100.0 + 6.0 * (n - 10))
    lost = replace(finger, phase=Phase.COASTING)
    seen = associate((lost,), (detection(140, 14),), 9)[0]
    alone, late = (predict(each, 16 * FRAME_US, 1.0).place.tip_px[0] for each in (lost, seen))
    assert alone < 130.0
    assert late == pytest.approx(140.0 + 2 * 13.0, abs=8.0)  # it moves on from where it was


@pytest.mark.parametrize(("off_px", "strayed"), [(10.0, False), (29.0, False), (50.0, True)])
def test_a_detection_far_off_its_place_contradicts_a_finger(off_px: float, strayed: bool) -> None:
    finger = associate(live(100), (detection(100 + off_px, 11),), 9)[0]
    assert finger.strayed is strayed


@pytest.mark.parametrize(("age", "claimed"), [(0, True), (4, True), (6, False)])
def test_an_old_detection_gives_no_place(age: int, claimed: bool) -> None:
    finger = live(100)[0]
    assert (claim(finger, (10 + age) * FRAME_US) is not None) is claimed


@pytest.mark.parametrize(
    ("speed_px", "late", "off_px", "there"),
    [
        (0.0, 1, 10.0, True),
        (0.0, 1, 15.0, False),
        (15.0, 1, 5.0, True),
        (15.0, 1, 15.0, False),
        (15.0, 3, 5.0, True),
        (15.0, 3, -15.0, False),
    ],
    ids=["near", "a knuckle", "it moves", "too far ahead", "of a slow tracker", "left behind"],
)
def test_a_tip_far_from_the_detection_is_another_finger(
    speed_px: float, late: int, off_px: float, there: bool
) -> None:
    """Even where no image shows the way of the hand since."""
    (finger,) = live(100)
    for n in range(1, 5):
        finger = measure(finger, 10 + n, 100.0 + speed_px * n)
    at_px = 100.0 + speed_px * (4 - late)
    (finger,) = associate((finger,), (detection(at_px, 14 - late),), 9)
    claimed = claim(finger, 14 * FRAME_US)
    assert claimed is not None
    assert is_there(claimed, tip(100.0 + speed_px * 4 + off_px)) is there


def test_two_pointers_on_one_finger_become_one() -> None:
    one, other = live(100, 300)
    there = measured(other, 11 * FRAME_US, tip(103.0, 305.0), False, 1.0)
    found = associate((one, there), (detection(100, 11),), 9)
    assert [finger.id for finger in found] == [1]


@pytest.mark.parametrize(
    ("side", "tip_px"),
    [(Side.RIGHT, (106.0, 330.0)), (Side.LEFT, (115.0, 300.0))],
    ids=["of an index finger", "of the other hand's"],
)
def test_a_thumb_next_to_the_line_of_another_finger_has_its_own_track(
    side: Side, tip_px: tuple[float, float]
) -> None:
    """One look shows both."""
    finger = replace(detection(100), finger=Finger.INDEX if side is Side.RIGHT else Finger.THUMB)
    thumb = replace(finger, side=side, finger=Finger.THUMB, tip_px=tip_px)
    fingers: tuple[Track, ...] = ()
    for n in range(12):
        look = tuple(replace(each, time_us=n * FRAME_US) for each in (finger, thumb))
        fingers = associate(fingers, look, len(fingers) + 1)
        fingers = tuple(
            measured(each, n * FRAME_US, tip(*place), True, 1.0)
            for each, place in zip(fingers, [(100.0, 300.0), (108.0, tip_px[1])], strict=False)
        )
    assert [each.id for each in fingers] == [1, 2]


@pytest.mark.parametrize("apart_px", [0.0, 8.0])
def test_two_landmarks_on_one_finger_are_one(apart_px: float) -> None:
    """The hand model puts two fingers on one where it sees them badly."""
    index = detection(100, 0)
    middle = replace(index, finger=Finger.MIDDLE, tip_px=(100.0, 300.0 + apart_px))
    (finger,) = associate((), (index,), 1)
    look = tuple(replace(each, time_us=FRAME_US) for each in (index, middle))
    assert [each.id for each in associate((finger,), look, 2)] == [1]


def test_a_finger_that_is_detected_elsewhere_for_long_ends() -> None:
    fingers = live(100)
    assert [finger.id for finger in associate(fingers, (detection(400, 12),), 9)] == [1, 9]
    assert [finger.id for finger in associate(fingers, (detection(400, 30),), 9)] == [9]


def test_a_track_on_a_hand_with_that_finger_elsewhere_ends() -> None:
    """Born of a first wrong look at a hand that comes in; the right finger has its own track."""
    wrong, right = live(100, 300)
    hand = replace(detection(300, 30), hand_px=np.full((21, 2), (110.0, 310.0)))
    right = replace(right, detection=replace(right.detection, time_us=29 * FRAME_US))
    assert [each.id for each in associate((wrong, right), (hand,), 9)] == [2]
    far = replace(hand, hand_px=np.full((21, 2), (200.0, 310.0)))
    assert [each.id for each in associate((wrong, right), (far,), 9)] == [1, 2]


def test_a_finger_next_to_the_other_hand_stays_while_the_tracker_loses_its_own() -> None:
    left, right = live(100, 120)
    left = replace(left, votes=-5)
    hand = replace(detection(100, 30), side=Side.LEFT, hand_px=np.full((21, 2), (110.0, 310.0)))
    assert [each.id for each in associate((left, right), (hand,), 9)] == [1, 2]


def maps(*xs: float) -> tuple[HeightMap, ...]:
    """A hand with one finger, its tip at x in each frame: from frame 4 on."""
    seen = []
    for n, x in enumerate(xs, 4):
        depth = np.full((480, 640), 500.0, np.float32)
        depth[300:420, round(x) - 8 : round(x) + 9] = 485.0
        seen.append(height_map(n * FRAME_US, depth, background(depth.shape), 0.0, 1.0))
    return tuple(seen)


def background(shape: tuple[int, ...]) -> Background:
    return Background(
        np.full(shape, 500.0, np.float32), np.ones(shape, np.float32), np.ones(shape, np.bool_)
    )


def test_a_track_and_its_bones_move_with_the_hand_at_once() -> None:
    """A resting hand that is fast one frame later: no prediction from its past knows that."""
    (finger,) = live(100)
    finger = replace(
        finger, history=tuple(replace(p, time_us=4 * FRAME_US) for p in finger.history)
    )
    moved = carry(finger, maps(100.0, 124.0), 1.0)
    assert moved.history[-1].place_mm == pytest.approx((124.0, 300.0), abs=1.5)
    assert moved.went_px == pytest.approx((24.0, 0.0), abs=1.0)


def test_a_tip_that_jumps_to_another_finger_does_not_take_the_bones_along() -> None:
    (finger,) = live(100)
    finger = replace(
        finger, history=tuple(replace(p, time_us=4 * FRAME_US) for p in finger.history)
    )
    jumped = measure(carry(finger, maps(100.0, 100.0), 1.0), 5, 130.0)
    assert jumped.went_px == pytest.approx((0.0, 0.0), abs=1.0)


def test_a_late_detection_counts_where_its_hand_is_now() -> None:
    seen = maps(100.0, 112.0, 124.0)
    (finger,) = associate((), (detection(100.0, 4),), 1, seen)
    assert finger.history[-1].place_mm == pytest.approx((124.0, 300.0), abs=3.0)
    assert finger.history[-1].time_us == 6 * FRAME_US
    assert finger.went_px == pytest.approx((24.0, 0.0), abs=1.0)


def test_a_hidden_tip_is_measured_worse_than_its_landmarks() -> None:
    shown, hidden = (
        measured(live(100)[0], 11 * FRAME_US, tip(115.0), True, 1.0, hidden)
        for hidden in (False, True)
    )
    assert shown.history[-1].place_mm[0] > 112.0
    assert hidden.history[-1].place_mm[0] < 106.0
    (seen,) = associate((hidden,), (detection(100.0, 11),), 9)
    assert seen.history[-1].place_mm[0] < hidden.history[-1].place_mm[0]
    (unmoved,) = associate((shown,), (detection(100.0, 11),), 9)
    assert unmoved.history[-1] == shown.history[-1]


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (2, 2), (3, 2), (4, 4), (5, 4)])
def test_few_pairs_are_those_of_the_solver(shape: tuple[int, int]) -> None:
    costs = np.random.default_rng(sum(shape)).uniform(0.0, 100.0, shape)
    rows, columns = load_solver()(costs)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    assert sorted(best_pairs(costs.tolist())) == sorted(pairs)
