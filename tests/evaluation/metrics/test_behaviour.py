"""Stuck touches, ids, stray pointers and fingers without one. Each figure has a known answer."""

import pytest

from halo_service.evaluation.metrics.behaviour import score_behaviour
from halo_service.evaluation.metrics.touches import score_touches
from halo_service.values import Finger, Touch
from tests.evaluation.small_world import (
    COUNT,
    SURFACE,
    contact,
    down,
    everywhere,
    finger,
    pointer,
    published_frames,
    truth_frames,
    truth_of,
    up,
)


def behaviour_of(lines, events=None, pointers=None, count=COUNT):
    truth, frames = truth_of(lines), published_frames(count, events, pointers)
    return score_behaviour(frames, truth, score_touches(frames, truth), SURFACE)


def test_a_quiet_finger_has_no_errors():
    behaviour = behaviour_of(truth_frames(COUNT))
    assert (behaviour.pointers, behaviour.fingers) == (COUNT, COUNT)
    wrong = (
        behaviour.stuck,
        behaviour.id_changes,
        behaviour.wrong_finger,
        behaviour.stray,
        behaviour.without_pointer,
    )
    assert wrong == (0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    "ends, stuck",
    [({10: [up()]}, 0), ({16: [up()]}, 0), ({18: [up()]}, 1), ({}, 1)],
    ids=["at once", "0.2 s later", "0.27 s later", "never"],
)
def test_a_touch_that_is_reported_long_after_its_end_is_stuck(ends, stuck):
    lines = [*truth_frames(COUNT), contact(5, 10)]
    assert behaviour_of(lines, {5: [down()]} | ends).stuck == stuck


@pytest.mark.parametrize(
    "again, up_at, stuck",
    [((15, 18), 20, 0), ((15, 18), 27, 1), ((15, 18, "middle"), 20, 1), ((18, 21), 22, 1)],
    ids=["re-tapped soon", "and then held on", "by another finger", "re-tapped late"],
)
def test_a_touch_that_lasts_over_a_missed_re_tap_is_not_stuck(again, up_at, stuck):
    begin, end, *which = again
    more = {"finger": which[0]} if which else {}
    lines = [*truth_frames(COUNT), contact(5, 10), contact(begin, end, **more)]
    assert behaviour_of(lines, {5: [down()], up_at: [up()]}).stuck == stuck


def pressed(begin, end, x_mm=100.0, **more):
    """The truth's lines of a finger that touches from frame to frame, and is in the air else."""
    fingers = {k: [finger(x_mm, height_mm=0.0, **more)] for k in range(begin, end + 1)}
    return [*truth_frames(COUNT, fingers), contact(begin, end, x_mm, **more)]


AIR = truth_frames(COUNT)
REPORTED_TWICE = {5: [down(1)], 8: [down(2)], 10: [up(1)]}
STUCK = {
    "a ghost that ends soon": (AIR, {5: [down()], 12: [up()]}, 0),
    "a ghost that goes on": (AIR, {5: [down()], 13: [up()]}, 1),
    "a ghost that never ends": (AIR, {5: [down()]}, 1),
    "a ghost long before a touch there": (pressed(18, 24), {5: [down()], 25: [up()]}, 1),
    "a doubled touch that ends with the finger's": (
        pressed(5, 10), REPORTED_TWICE | {11: [up(2)]}, 0),
    "a doubled touch that never ends": (pressed(5, 10), REPORTED_TWICE, 1),
    "outside, while a finger touches 35 mm from there": (
        pressed(5, 25, 135.0), {6: [down(2)], 26: [up(2)]}, 0),
    "outside, on and on": (pressed(5, 12, 135.0), {6: [down(2)], 26: [up(2)]}, 1),
    "reported of this finger, far from it": (pressed(5, 25, 160.0), {6: [down()], 26: [up()]}, 0),
    "reported of a finger in the air, far from the one that touches": (
        pressed(5, 25, 160.0, finger="middle"), {6: [down()], 26: [up()]}, 1),
    "during a touch that the recording's end cuts off": (
        [line for line in pressed(5, 29) if "contact" not in line], {5: [down()]}, 0),
    "of a tap that no frame was taken of": ([*AIR, contact(4.3, 4.6)], {5: [down()]}, 1),
}  # fmt: skip


@pytest.mark.parametrize("lines, events, stuck", STUCK.values(), ids=STUCK.keys())
def test_false_touches_can_be_stuck_too(lines, events, stuck):
    assert behaviour_of(lines, events).stuck == stuck


@pytest.mark.parametrize("lifts, stuck", [(COUNT, 0), (18, 1)], ids=["to the end", "left behind"])
def test_a_touch_reported_again_during_a_drag_is_stuck_only_without_its_finger(lifts, stuck):
    fingers = {k: [finger(10.0 * k, height_mm=0.0 if k < lifts else 30.0)] for k in range(COUNT)}
    lines = [*truth_frames(COUNT, fingers), contact(0, min(lifts, COUNT) - 1, 0.0)]
    reported = {k: [pointer(x_mm=10.0 * k, finger=Finger.MIDDLE)] for k in range(COUNT)}
    events = {0: [down(x_mm=0.0)], 8: [up()], 9: [down(x_mm=90.0)], COUNT - 1: [up()]}
    assert behaviour_of(lines, events, reported).stuck == stuck


def test_a_finger_that_stays_keeps_its_id():
    renamed = {k: [pointer(1 if k < 10 else 2)] for k in range(COUNT)}
    assert behaviour_of(truth_frames(COUNT), pointers=renamed).id_changes == 1
    left = {k: [finger(x_mm=900.0)] for k in range(8, 12)}
    assert behaviour_of(truth_frames(COUNT, left), pointers=renamed).id_changes == 0


def test_hovering_pointers_are_counted_separately():
    reported = {k: [pointer(state=Touch.TOUCH if k < 10 else Touch.HOVER)] for k in range(COUNT)}
    behaviour = behaviour_of(truth_frames(COUNT), pointers=reported)
    assert (behaviour.pointers, behaviour.hovering) == (COUNT, COUNT - 10)


def test_an_inactive_finger_keeps_its_id_too():
    """Two open hands: whichever finger has a pointer, be it to touch or not."""
    fingers = everywhere([finger(100.0), finger(140.0, finger="ring")])
    reported = {
        k: [pointer(1), pointer(2 if k < 10 else 3, 140.0, finger=Finger.RING)]
        for k in range(COUNT)
    }
    behaviour = behaviour_of(truth_frames(COUNT, fingers), pointers=reported)
    assert (behaviour.id_changes, behaviour.without_pointer, behaviour.fingers) == (1, 0, COUNT)


def test_neighbours_do_not_get_each_others_pointers():
    fingers = everywhere([finger(100.0), finger(118.0, finger="middle")])
    reported = everywhere([pointer(1, 100.0), pointer(2, 118.0, finger=Finger.MIDDLE)])
    reported |= {k: reported[k][1:] for k in range(10, 15)}  # lost for a while
    behaviour = behaviour_of(truth_frames(COUNT, fingers), pointers=reported)
    assert (behaviour.without_pointer, behaviour.id_changes, behaviour.stray) == (5, 0, 0)


@pytest.mark.parametrize("moving, unseen", [("index", 0), ("ring", COUNT)])
def test_an_inactive_finger_needs_no_pointer(moving, unseen):
    fingers = everywhere([finger(100.0), finger(140.0, finger="ring")])
    lines = [*truth_frames(COUNT, fingers), contact(5, 10, finger=moving)]
    behaviour = behaviour_of(lines, pointers=everywhere([pointer(1, 100.0)]))
    assert (behaviour.without_pointer, behaviour.fingers) == (unseen, COUNT + unseen)


def test_a_pointer_without_a_finger_is_stray_but_not_at_once():
    there = {k: [finger()] if k < 10 else [] for k in range(COUNT)}
    behaviour = behaviour_of(truth_frames(COUNT, there))
    assert behaviour.stray == COUNT - 10 - 9  # 0.3 s after the hand has left


def test_a_touch_of_the_wrong_finger_is_counted():
    lines = [*truth_frames(COUNT), contact(5, 10)]
    middle = everywhere([pointer(finger=Finger.MIDDLE)])
    assert behaviour_of(lines, {5: [down()], 10: [up()]}, middle).wrong_finger == 1
