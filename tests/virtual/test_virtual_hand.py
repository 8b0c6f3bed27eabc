"""The hand: pads lie exactly at their targets, and nothing else touches the table."""

import itertools

import numpy as np
import pytest

from halo_service.values import Finger, Side
from halo_service.virtual.anatomy import hand_mesh
from halo_service.virtual.hand import fist, open_hand, pointing, resting
from halo_service.virtual.skeleton import FingerPose, User, indentation_mm, posed, tip_of
from halo_service.virtual.users import draw_user

SIDES = (Side.LEFT, Side.RIGHT)
PITCHES = (15.0, 30.0, 45.0, 60.0, 75.0)
YAWS = (-40.0, -15.0, 0.0, 25.0, 40.0)
USERS = [draw_user(seed) for seed in range(6)]


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("finger", list(Finger))
def test_the_pad_lies_exactly_at_its_target(side, finger):
    for user, pitch, yaw, height in zip(
        itertools.cycle(USERS), PITCHES, YAWS, (0.0, 1.0, 10.0, 40.0, 90.0), strict=False
    ):
        aim = FingerPose(120.0, 70.0, height, 0.0, pitch, yaw)
        hand = posed(user, pointing(user, side, aim, finger=finger))
        assert hand.pad(finger) == pytest.approx([120.0, 70.0, -height], abs=1e-9)
        if finger is Finger.THUMB and pitch > 45.0:
            continue  # it lies across the hand: no tilt gets it that steep
        assert hand.pitch_yaw(finger) == pytest.approx((pitch, yaw), abs=1e-6)
        assert hand.pointing(finger) or finger is Finger.THUMB


def test_the_skin_ends_where_the_pad_does():
    for pitch in PITCHES:
        hand = posed(User(), pointing(User(), Side.RIGHT, FingerPose(150, 100, 0, 0, pitch, 0)))
        tip = hand.vertices[np.linalg.norm(hand.vertices - hand.pad(Finger.INDEX), axis=1) < 12.0]
        assert -0.6 < tip[:, 2].max() <= 0.01


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("curl", [0.0, 0.5, 1.0])
def test_nothing_but_the_pad_reaches_the_table(side, curl):
    for user, pitch in itertools.product(USERS, PITCHES):
        hand = posed(user, pointing(user, side, FingerPose(150, 100, 0, 0, pitch, 10), curl=curl))
        elsewhere = np.linalg.norm(hand.vertices - hand.pad(Finger.INDEX), axis=1) > 15.0
        assert hand.vertices[elsewhere, 2].max() < 0.0
        others = [hand.pad(f)[2] for f in Finger if f is not Finger.INDEX]
        assert max(others) < -0.5


def test_a_press_sinks_the_tip_and_softer_pads_sink_further():
    soft, firm = User(pad_mm=2.6, pad_g=70.0), User(pad_mm=1.8, pad_g=120.0)
    for force in (25.0, 100.0, 385.0):
        for user in (soft, firm):
            aim = FingerPose(150, 100, 0, force)
            depth = tip_of(user, pointing(user, Side.RIGHT, aim), Finger.INDEX)[2]
            assert depth == pytest.approx(indentation_mm(user, force))
        assert indentation_mm(soft, force) > indentation_mm(firm, force)
    assert indentation_mm(soft, 0.0) == 0.0
    assert indentation_mm(soft, 1e6) == pytest.approx(2.6)


def test_a_left_hand_is_a_right_hand_in_a_mirror():
    right = posed(User(), pointing(User(), Side.RIGHT, FingerPose(0, 0, 5, 0, 40, 20)))
    left = posed(User(), pointing(User(), Side.LEFT, FingerPose(0, 0, 5, 0, 40, -20)))
    assert left.vertices * [-1, 1, 1] == pytest.approx(right.vertices, abs=1e-9)


@pytest.mark.parametrize("side", SIDES)
def test_every_finger_of_an_open_hand_has_its_own_height(side):
    heights = {finger: 3.0 + 4.0 * int(finger) for finger in Finger}
    for user in USERS:
        pose = open_hand(user, side, FingerPose(150, 80, 11, 0, 55, 0), heights, {})
        hand = posed(user, pose)
        for finger in Finger:
            assert -hand.pad(finger)[2] == pytest.approx(heights[finger], abs=1e-6)
            assert hand.pointing(finger)


def test_a_resting_hand_lies_on_the_table_and_presses_with_no_finger():
    for side in SIDES:
        hand = posed(User(), resting(User(), side, 150.0, 100.0, 0.0))
        lowest = (hand.joints[..., 2] + hand.radii).max()
        assert lowest == pytest.approx(0.0, abs=1e-9)
        assert hand.force_g == (0.0,) * 5


def test_a_fist_rests_on_its_knuckles_and_no_finger_points():
    for side in SIDES:
        hand = posed(User(), fist(User(), side, 150.0, 100.0, 0.0))
        assert (hand.joints[..., 2] + hand.radii)[:, 1:].max() == pytest.approx(0.0, abs=1e-9)
        assert not any(hand.pointing(f) for f in Finger)


@pytest.mark.parametrize("girth", [0.9, 1.0, 1.1])
def test_the_mesh_is_closed_fine_enough_and_turned_outward(girth):
    mesh = hand_mesh(girth)
    assert len(mesh.faces) >= 4_700  # with half of that the hand tracker saw no hand
    edges = [mesh.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]
    _, count = np.unique(np.sort(np.concatenate(edges)), axis=0, return_counts=True)
    assert set(count) <= {2, 4}
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0.0
    assert mesh.weights.sum(axis=1) == pytest.approx(np.ones(len(mesh.vertices)))
