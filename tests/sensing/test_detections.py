"""The tracker's hands become detections of extended fingers, each hand once."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.sensing.detections import detections
from halo_service.sensing.scale import Scale
from halo_service.values import Finger, Hand, Side, Tracked
from tests.drawn import PLAIN

SCALE = Scale(np.full((576, 640), 500, np.uint16), PLAIN.profile)
"""1 px is 1 mm."""
ROOTS = {Finger.THUMB: -50.0, Finger.INDEX: -20.0, Finger.MIDDLE: 0.0}
ROOTS |= {Finger.RING: 20.0, Finger.LITTLE: 40.0}


def hand(
    *extended: Finger, at: tuple[float, float] = (320.0, 400.0), side: Side = Side.RIGHT
) -> Hand:
    """A hand that points up the image, its wrist at a place; other fingers are curled in."""
    marks = np.zeros((21, 2))
    for finger, x in ROOTS.items():
        out = finger in extended
        if finger is Finger.THUMB:
            joints = [(x, -20.0), (x - 10, -30), (x - 20, -40), (x - 30, -50)]
            joints[2:] = joints[2:] if out else [(x + 20, -40.0), (x + 40, -45.0)]
        else:
            joints = [(x, -80.0), (x, -120.0), (x, -100.0), (x, -85.0)]
            joints[2:] = [(x, -145.0), (x, -165.0)] if out else joints[2:]
        marks[1 + 4 * int(finger) : 5 + 4 * int(finger)] = joints
    return Hand(side, marks + np.array(at), 0.9)


def seen(*hands: Hand, wanted: str = "all") -> list[tuple[Side, Finger]]:
    found = detections(Tracked(0, hands), SCALE, wanted)  # type: ignore[arg-type]
    return [(each.side, each.finger) for each in found if each.extended]


@pytest.mark.parametrize(
    "extended", [(), (Finger.INDEX,), (Finger.THUMB, Finger.LITTLE), tuple(Finger)]
)
def test_extended_fingers_are_distinguished_from_curled_ones(extended: tuple[Finger, ...]) -> None:
    assert [finger for _, finger in seen(hand(*extended))] == list(extended)


def test_index_fingers_alone_where_no_other_is_wanted() -> None:
    assert seen(hand(*Finger), wanted="index") == [(Side.RIGHT, Finger.INDEX)]


@pytest.mark.parametrize(
    ("apart_px", "hands"), [(0.0, 1), (20.0, 1), (60.0, 2), (200.0, 2)], ids=str
)
def test_a_hand_that_is_seen_twice_is_one_hand(apart_px: float, hands: int) -> None:
    other = hand(Finger.INDEX, at=(320.0 + apart_px, 400.0), side=Side.LEFT)
    assert len(seen(hand(Finger.INDEX), other)) == hands


def test_landmarks_that_have_collapsed_are_no_hand() -> None:
    assert seen(Hand(Side.RIGHT, np.full((21, 2), 300.0), 0.99)) == []


@pytest.mark.parametrize("joint", [7, 6], ids=["the last joint", "the middle joint"])
def test_the_joint_lies_on_the_line_to_the_fingers_root(joint: int) -> None:
    marks = hand(Finger.INDEX).landmarks_px.copy()
    marks[joint, 0] += 9.0  # badly seen
    detection = detections(Tracked(0, (Hand(Side.RIGHT, marks, 0.9),)), SCALE)[0]
    assert detection.distal_px[0] == pytest.approx(detection.tip_px[0])


def test_without_tracked_hands_there_is_no_finger() -> None:
    assert detections(None, SCALE) == ()
