"""Levels, places, speeds, conduct, re-taps and keys: figures with an answer known beforehand."""

import numpy as np
import pytest

from halo_service.evaluation.metrics.behaviour import score_conduct
from halo_service.evaluation.metrics.keystrokes import score_keys, score_phrases
from halo_service.evaluation.metrics.levels import score_levels, score_seam
from halo_service.evaluation.metrics.retaps import (
    Retap,
    score_threshold,
    threshold_mm,
    told_by_lift,
)
from halo_service.evaluation.metrics.spatial import (
    as_the_paper,
    ellipse,
    from_target,
    from_truth,
    spatial,
)
from halo_service.evaluation.metrics.speeds import (
    Speed,
    rank_correlation,
    relative_error,
    score_strikes,
    score_velocity,
)
from halo_service.evaluation.metrics.touches import score_touches
from halo_service.evaluation.metrics.truth import read_truth
from halo_service.values import Finger, Touch
from halo_service.virtual.scenarios.typing import keys
from tests.evaluation.small_world import (
    FRAME_US,
    SURFACE,
    contact,
    down,
    finger,
    pointer,
    told_frames,
    truth_frames,
    up,
)

COUNT = 30
STEP = {"step": "hover", "from_s": 0.0, "to_s": 1.0, "height_mm": 10.0}
PRESS = {"step": "pressure", "from_s": 0.0, "to_s": 1.0, "force_g": 96.25}


def truth_of(lines):
    return read_truth(lines, SURFACE)


def everywhere(value, count=COUNT):
    return dict.fromkeys(range(count), value)


def held(height_mm, pointers, step=STEP, **more):
    truth = truth_of(truth_frames(COUNT, everywhere([finger(height_mm=height_mm, **more)])))
    return score_levels(told_frames(COUNT, pointers=pointers), truth, [step])[0]


def test_hover_is_off_by_what_it_differs_from_the_fingers_own_height():
    trial = held(10.4, everywhere([pointer(hover_mm=9.0)]))
    assert (trial.error, trial.bias, trial.told) == pytest.approx((1.4, -1.4, 9.0))
    assert (trial.kind, trial.level, trial.unseen) == ("hover", 10.0, 0.0)


def test_errors_up_and_down_do_not_cancel():
    by_turns = {k: [pointer(hover_mm=10.0 + 2.0 * (-1) ** k)] for k in range(COUNT)}
    trial = held(10.0, by_turns)
    assert (trial.error, trial.bias) == pytest.approx((2.0, 0.0))


def test_frames_without_a_pointer_are_unseen_rather_than_accurate():
    half = {k: [pointer(hover_mm=10.0)] if k % 2 else [] for k in range(COUNT)}
    trial = held(10.0, half)
    assert (trial.error, trial.unseen) == pytest.approx((0.0, 0.5))
    silent = held(10.0, everywhere([]))
    assert np.isnan(silent.error)
    assert silent.unseen == 1.0


def test_a_half_curled_finger_that_hangs_lower_is_not_the_one_that_is_held():
    hanging = finger(finger="middle", x_mm=125.0, height_mm=4.0)
    fingers = everywhere([finger(height_mm=10.0), hanging])
    told = told_frames(COUNT, pointers=everywhere([pointer(hover_mm=9.0)]))
    trial = score_levels(told, truth_of(truth_frames(COUNT, fingers)), [STEP])[0]
    assert (trial.error, trial.unseen) == pytest.approx((1.0, 0.0))


def test_a_pointer_of_another_finger_is_no_reading():
    assert held(10.0, everywhere([pointer(x_mm=150.0)])).unseen == 1.0


@pytest.mark.parametrize(
    "told, error",
    [
        ({"state": Touch.TOUCH, "force_g": 96.25}, 0.0),
        ({"state": Touch.TOUCH, "force_g": 96.25 + 38.5}, 10.0),
        ({"state": Touch.HOVER, "force_g": 0.0}, 25.0),
    ],
    ids=["exactly", "a tenth of 385 g too much", "in the air: nothing"],
)
def test_pressure_is_off_by_shares_of_385_g(told, error):
    trial = held(0.0, everywhere([pointer(hover_mm=0.0, **told)]), PRESS, force_g=96.25)
    assert trial.error == pytest.approx(error)


@pytest.mark.parametrize("state", [Touch.TOUCH, Touch.HOVER])
def test_who_does_not_say_how_hard_gives_no_reading(state):
    silent = {"state": state, "hover_mm": 0.0, "force_g": -1.0}
    trial = held(0.0, everywhere([pointer(**silent)]), PRESS, force_g=96.25)
    assert np.isnan([trial.error, trial.bias, trial.told]).all()
    assert trial.unseen == 1.0
    half = {k: [pointer(**silent | ({"force_g": 96.25} if k % 2 else {}))] for k in range(COUNT)}
    trial = held(0.0, half, PRESS, force_g=96.25)
    assert trial.unseen == pytest.approx(0.5)
    assert trial.error == pytest.approx(0.0 if state is Touch.TOUCH else 25.0)


def test_frames_beside_the_step_do_not_count():
    wrong_outside = everywhere([pointer(hover_mm=10.0)])
    wrong_outside |= {k: [pointer(hover_mm=99.0)] for k in (0, 1, 2, 20, 21)}
    step = STEP | {"from_s": 0.1, "to_s": 0.6}
    assert held(10.0, wrong_outside, step).error == 0.0


def test_a_jump_is_what_hover_changes_beyond_the_finger():
    heights = {k: 20.0 - k for k in range(10)}
    truth = truth_of(truth_frames(10, {k: [finger(height_mm=h)] for k, h in heights.items()}))
    told = {k: [pointer(hover_mm=h + (5.0 if k >= 6 else 0.0))] for k, h in heights.items()}
    jumps = score_seam(told_frames(10, pointers=told), truth)
    assert [round(jump.jump_mm, 6) for jump in jumps] == [0.0] * 5 + [5.0] + [0.0] * 3
    assert jumps[5].height_mm == 14.0


def hits_at(offsets):
    """One touch a frame at its target, told off by so much."""
    lines, downs = [], {}
    for k, (dx, dy) in enumerate(offsets):
        frame = 10 * k + 5
        lines.append(contact(frame - 0.5, frame + 3, target_mm=[102.0, 100.0]))
        downs[frame] = [down(x_mm=100.0 + dx, y_mm=100.0 + dy)]
    count = 10 * len(offsets) + 10
    return score_touches(told_frames(count, downs), truth_of([*truth_frames(count), *lines])).hits


def test_spatial_error_is_from_the_true_place_with_nothing_removed():
    off = spatial(from_truth(hits_at([(3.0, 4.0), (3.0, 4.0), (0.0, 4.0), (6.0, 4.0)])))
    assert off.bias_mm == pytest.approx((3.0, 4.0))
    assert off.mean_mm == pytest.approx((5.0 + 5.0 + 4.0 + 52**0.5) / 4)


def test_the_papers_reduction_takes_the_common_offset_and_the_outliers():
    errors = from_target(hits_at([(9.0, 1.0), (9.0, -1.0), (10.0, 0.0), (8.0, 0.0)] * 5))
    assert spatial(errors).bias_mm == pytest.approx((7.0, 0.0))
    assert spatial(as_the_paper(errors)).mean_mm == pytest.approx(1.0)
    far = np.vstack([errors, [[60.0, 0.0]]])
    assert len(as_the_paper(far)) == len(errors)


def test_the_ellipse_holds_95_percent_of_a_normal_cloud():
    rng = np.random.default_rng(5)
    turn = np.radians(30.0)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    cloud = rng.normal(0.0, (4.0, 1.5), (20_000, 2)) @ axes + (7.0, -2.0)
    found = ellipse(cloud)
    assert (found.x_mm, found.y_mm) == pytest.approx((7.0, -2.0), abs=0.1)
    assert found.angle_deg == pytest.approx(30.0, abs=1.0)
    along = (cloud - (found.x_mm, found.y_mm)) @ axes.T / (found.major_mm, found.minor_mm)
    assert np.mean(np.hypot(*along.T) <= 1.0) == pytest.approx(0.95, abs=0.01)


def test_no_touch_has_no_spatial_error_and_one_has_no_spread():
    assert spatial(from_truth(())) is None
    assert spatial(from_truth(hits_at([(3.0, 4.0)]))).ellipse.major_mm == 0.0


def test_strikes_are_judged_by_share_and_by_order():
    lines = [contact(5, 8), contact(15, 18, strike_mm_s=400.0)]
    downs = {5: [down(strike_mm_s=150.0)], 15: [down(strike_mm_s=300.0)]}
    truth = truth_of([*truth_frames(COUNT), *lines])
    speeds = score_strikes(score_touches(told_frames(COUNT, downs), truth).hits)
    assert relative_error(speeds) == pytest.approx(0.25)


def test_ranks_need_enough_and_something_to_rank():
    rising = [Speed(float(k), float(k**2), 0.0) for k in range(1, 8)]
    assert rank_correlation(rising) == pytest.approx(1.0)
    assert np.isnan(rank_correlation(rising[:4]))
    assert np.isnan(rank_correlation([Speed(1.0, float(k), 0.0) for k in range(9)]))


def test_velocity_is_judged_against_the_true_path():
    step_mm = 300.0 * FRAME_US / 1e6
    truth = truth_of(truth_frames(10, {k: [finger(100.0 + step_mm * k)] for k in range(10)}))
    told = {k: [pointer(x_mm=100.0 + step_mm * k, vx_mm_s=240.0)] for k in range(10)}
    speeds = score_velocity(told_frames(10, pointers=told), truth)
    assert len(speeds) == 8  # the ends have no neighbours
    assert relative_error(speeds) == pytest.approx(0.2, abs=1e-3)
    sideways = {k: [pointer(x_mm=100.0 + step_mm * k, vy_mm_s=300.0)] for k in range(10)}
    assert relative_error(score_velocity(told_frames(10, pointers=sideways), truth)) > 1.0


def conduct_of(lines, events=None, pointers=None, count=COUNT):
    truth, frames = truth_of(lines), told_frames(count, events, pointers)
    return score_conduct(frames, truth, score_touches(frames, truth), SURFACE)


def test_a_quiet_finger_gives_no_cause_for_complaint():
    conduct = conduct_of(truth_frames(COUNT))
    assert (conduct.pointers, conduct.fingers) == (COUNT, COUNT)
    wrong = conduct.stuck, conduct.id_changes, conduct.misnamed, conduct.strange, conduct.unseen
    assert wrong == (0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    "ends, stuck",
    [({10: [up()]}, 0), ({16: [up()]}, 0), ({18: [up()]}, 1), ({}, 1)],
    ids=["at once", "0.2 s later", "0.27 s later", "never"],
)
def test_a_touch_that_is_told_long_after_its_end_sticks(ends, stuck):
    lines = [*truth_frames(COUNT), contact(5, 10)]
    assert conduct_of(lines, {5: [down()]} | ends).stuck == stuck


@pytest.mark.parametrize(
    "again, up_at, stuck",
    [((15, 18), 20, 0), ((15, 18), 27, 1), ((15, 18, "middle"), 20, 1), ((18, 21), 22, 1)],
    ids=["re-tapped soon", "and then held on", "by another finger", "re-tapped late"],
)
def test_a_touch_that_is_told_on_over_a_missed_re_tap_does_not_stick(again, up_at, stuck):
    begin, end, *which = again
    more = {"finger": which[0]} if which else {}
    lines = [*truth_frames(COUNT), contact(5, 10), contact(begin, end, **more)]
    assert conduct_of(lines, {5: [down()], up_at: [up()]}).stuck == stuck


def pressed(begin, end, x_mm=100.0, **more):
    """The truth's lines of a finger that touches from frame to frame, and is in the air else."""
    fingers = {k: [finger(x_mm, height_mm=0.0, **more)] for k in range(begin, end + 1)}
    return [*truth_frames(COUNT, fingers), contact(begin, end, x_mm, **more)]


AIR = truth_frames(COUNT)
TOLD_TWICE = {5: [down(1)], 8: [down(2)], 10: [up(1)]}
STUCK = {
    "a ghost that ends soon": (AIR, {5: [down()], 12: [up()]}, 0),
    "a ghost that goes on": (AIR, {5: [down()], 13: [up()]}, 1),
    "a ghost that never ends": (AIR, {5: [down()]}, 1),
    "a ghost long before a touch there": (pressed(18, 24), {5: [down()], 25: [up()]}, 1),
    "a doubled touch that ends with the finger's": (
        pressed(5, 10), TOLD_TWICE | {11: [up(2)]}, 0),
    "a doubled touch that never ends": (pressed(5, 10), TOLD_TWICE, 1),
    "outside, while a finger touches 35 mm from there": (
        pressed(5, 25, 135.0), {6: [down(2)], 26: [up(2)]}, 0),
    "outside, on and on": (pressed(5, 12, 135.0), {6: [down(2)], 26: [up(2)]}, 1),
    "told of this finger, far from it": (pressed(5, 25, 160.0), {6: [down()], 26: [up()]}, 0),
    "told of a finger in the air, far from the one that touches": (
        pressed(5, 25, 160.0, finger="middle"), {6: [down()], 26: [up()]}, 1),
    "during a touch that the take's end cuts off": (
        [line for line in pressed(5, 29) if "contact" not in line], {5: [down()]}, 0),
    "of a tap that no frame was taken of": ([*AIR, contact(4.3, 4.6)], {5: [down()]}, 1),
}  # fmt: skip


@pytest.mark.parametrize("lines, events, stuck", STUCK.values(), ids=STUCK.keys())
def test_what_is_no_touch_can_stick_too(lines, events, stuck):
    assert conduct_of(lines, events).stuck == stuck


@pytest.mark.parametrize("lifts, stuck", [(COUNT, 0), (18, 1)], ids=["to the end", "left behind"])
def test_a_touch_told_anew_along_a_drag_sticks_only_without_its_finger(lifts, stuck):
    fingers = {k: [finger(10.0 * k, height_mm=0.0 if k < lifts else 30.0)] for k in range(COUNT)}
    lines = [*truth_frames(COUNT, fingers), contact(0, min(lifts, COUNT) - 1, 0.0)]
    told = {k: [pointer(x_mm=10.0 * k, finger=Finger.MIDDLE)] for k in range(COUNT)}
    events = {0: [down(x_mm=0.0)], 8: [up()], 9: [down(x_mm=90.0)], COUNT - 1: [up()]}
    assert conduct_of(lines, events, told).stuck == stuck


def test_a_finger_that_stays_keeps_its_id():
    renamed = {k: [pointer(1 if k < 10 else 2)] for k in range(COUNT)}
    assert conduct_of(truth_frames(COUNT), pointers=renamed).id_changes == 1
    left = {k: [finger(x_mm=900.0)] for k in range(8, 12)}
    assert conduct_of(truth_frames(COUNT, left), pointers=renamed).id_changes == 0


def test_pointers_in_the_air_are_told_apart_from_those_that_touch():
    told = {k: [pointer(state=Touch.TOUCH if k < 10 else Touch.HOVER)] for k in range(COUNT)}
    conduct = conduct_of(truth_frames(COUNT), pointers=told)
    assert (conduct.pointers, conduct.aloft) == (COUNT, COUNT - 10)


def test_a_finger_that_merely_hangs_beside_keeps_its_id_too():
    """Two open hands: whichever finger has a pointer, be it to touch or not."""
    fingers = everywhere([finger(100.0), finger(140.0, finger="ring")])
    told = {
        k: [pointer(1), pointer(2 if k < 10 else 3, 140.0, finger=Finger.RING)]
        for k in range(COUNT)
    }
    conduct = conduct_of(truth_frames(COUNT, fingers), pointers=told)
    assert (conduct.id_changes, conduct.unseen, conduct.fingers) == (1, 0, COUNT)


def test_neighbours_do_not_take_each_others_pointers():
    fingers = everywhere([finger(100.0), finger(118.0, finger="middle")])
    told = everywhere([pointer(1, 100.0), pointer(2, 118.0, finger=Finger.MIDDLE)])
    told |= {k: told[k][1:] for k in range(10, 15)}  # the index finger's is lost for a while
    conduct = conduct_of(truth_frames(COUNT, fingers), pointers=told)
    assert (conduct.unseen, conduct.id_changes, conduct.strange) == (5, 0, 0)


@pytest.mark.parametrize("plays, unseen", [("index", 0), ("ring", COUNT)])
def test_a_finger_that_merely_hangs_beside_need_not_be_a_pointer(plays, unseen):
    fingers = everywhere([finger(100.0), finger(140.0, finger="ring")])
    lines = [*truth_frames(COUNT, fingers), contact(5, 10, finger=plays)]
    conduct = conduct_of(lines, pointers=everywhere([pointer(1, 100.0)]))
    assert (conduct.unseen, conduct.fingers) == (unseen, COUNT + unseen)


def test_a_pointer_where_no_finger_is_is_strange_but_not_at_once():
    there = {k: [finger()] if k < 10 else [] for k in range(COUNT)}
    conduct = conduct_of(truth_frames(COUNT, there))
    assert conduct.strange == COUNT - 10 - 9  # 0.3 s after the hand has left


def test_a_touch_told_of_another_finger_is_misnamed():
    lines = [*truth_frames(COUNT), contact(5, 10)]
    middle = everywhere([pointer(finger=Finger.MIDDLE)])
    assert conduct_of(lines, {5: [down()], 10: [up()]}, middle).misnamed == 1


def test_retaps_are_those_that_the_script_names():
    lines = [contact(5, 8), contact(12, 15), contact(20, 23)]
    truth = truth_of([*truth_frames(COUNT), *lines])
    touches = score_touches(told_frames(COUNT, {5: [down()], 20: [down()]}), truth)
    script = [
        {"step": "retap", "from_s": 9 / 30, "to_s": 15 / 30, "lift_mm": 0.5},
        {"step": "retap", "from_s": 16 / 30, "to_s": 23 / 30, "lift_mm": 4.0},
    ]
    assert score_threshold(touches, truth, script) == (Retap(0.5, False), Retap(4.0, True))


@pytest.mark.parametrize(
    "told, threshold",
    [
        ({1.0: 100, 2.0: 100, 3.0: 100}, 1.0),
        ({1.0: 50, 2.0: 99, 3.0: 100}, 2.0),
        ({1.0: 100, 2.0: 98, 3.0: 100}, 3.0),
        ({1.0: 100, 2.0: 100, 3.0: 98}, None),
    ],
    ids=["every lift", "from 2 mm on", "a gap counts against what is below", "none"],
)
def test_the_threshold_is_the_least_lift_from_which_on_nearly_all_are_told(told, threshold):
    retaps = [Retap(lift, k < count) for lift, count in told.items() for k in range(100)]
    assert threshold_mm(told_by_lift(retaps)) == threshold


def typed_touches(text, told, again=(), aside_mm=0.0):
    """Type a text; `told`: what of each stroke is published, mm beside it or None.

    `again`: mm beside the key at which some strokes are told once more, by their number;
    `aside_mm`: how far beside the middle of their keys the fingers land.
    """
    layout, lines, downs = keys(), [], {}
    for k, (character, off) in enumerate(zip(text, told, strict=True)):
        x, y = layout[character].middle
        landed = x + aside_mm, y
        lines.append(contact(15 * k + 5, 15 * k + 8, *landed, key=character, target_mm=[x, y]))
        if off is not None:
            downs[15 * k + 5] = [down(x_mm=x + off, y_mm=y)]
        if k in dict(again):
            downs[15 * k + 7] = [down(x_mm=x + dict(again)[k], y_mm=y)]
    count = 15 * len(text) + 10
    return score_touches(told_frames(count, downs), truth_of([*truth_frames(count), *lines]))


def test_keys_are_wrong_where_another_was_told():
    touches = typed_touches("table", [0.0, 5.0, 12.0, None, -3.0])
    counted = score_keys(touches)
    assert (counted.struck, counted.wrong, counted.missed) == (5, 1, 1)


@pytest.mark.parametrize(
    "again, aside_mm, doubled",
    [
        ({}, 0.0, 0),
        ({0: 0.0}, 0.0, 1),
        ({0: 0.0, 2: 16.0}, 0.0, 2),
        ({0: -24.0}, 0.0, 0),
        ({0: 0.0}, 7.0, 0),
    ],
    ids=[
        "each once",
        "one twice",
        "one as its neighbour, too",
        "beside the keyboard",
        "landed at the key's edge",
    ],
)
def test_keys_are_doubled_where_the_finger_landed_well_inside(again, aside_mm, doubled):
    touches = typed_touches("qaz", [0.0] * 3, tuple(again.items()), aside_mm)
    assert len(touches.doubled) == len(again)
    assert score_keys(touches).doubled == doubled


def test_a_doubled_down_counts_for_the_stroke_that_it_is_nearest_to():
    """Two fingers at once: one well inside `q`, the other at the edge of `w` and told twice."""
    layout = keys()
    (qx, y), (wx, _) = layout["q"].middle, layout["w"].middle
    lines = [
        contact(5, 9, qx, y, key="q", target_mm=[qx, y]),
        contact(5, 9, wx + 7.0, y, key="w", target_mm=[wx, y], hand="left"),
    ]
    downs = {5: [down(1, qx, y), down(2, wx, y)], 7: [down(3, wx + 3.0, y)]}
    touches = score_touches(told_frames(15, downs), truth_of([*truth_frames(15), *lines]))
    counted = score_keys(touches)
    assert len(touches.doubled) == 1
    assert (counted.struck, counted.doubled) == (1, 0)


def test_the_text_is_what_the_told_keys_spell():
    (phrase,) = score_phrases(typed_touches("table", [0.0, 0.0, 16.0, None, 0.0]))
    assert phrase.presented == "table"
    assert (phrase.typed.correct, phrase.typed.uncorrected) == (3, 2)  # "tane"
    assert phrase.perfect.uncorrected == 0
    assert phrase.perfect.wpm == pytest.approx(60 / 5 / (15 * FRAME_US / 1e6), rel=1e-4)
