"""Held heights and forces, and jumps of hover. Each figure has a known answer."""

import numpy as np
import pytest

from halo_service.evaluation.metrics.levels import score_jumps, score_levels
from halo_service.values import Touch
from tests.evaluation.small_world import (
    COUNT,
    everywhere,
    finger,
    pointer,
    published_frames,
    truth_frames,
    truth_of,
)

STEP = {"step": "hover", "from_s": 0.0, "to_s": 1.0, "height_mm": 10.0}
PRESS = {"step": "pressure", "from_s": 0.0, "to_s": 1.0, "force_g": 96.25}


def held(height_mm, pointers, step=STEP, **more):
    truth = truth_of(truth_frames(COUNT, everywhere([finger(height_mm=height_mm, **more)])))
    return score_levels(published_frames(COUNT, pointers=pointers), truth, [step])[0]


def test_hover_is_off_by_what_it_differs_from_the_fingers_own_height():
    trial = held(10.4, everywhere([pointer(hover_mm=9.0)]))
    assert (trial.error, trial.bias, trial.reported) == pytest.approx((1.4, -1.4, 9.0))
    assert (trial.kind, trial.level, trial.no_reading) == ("hover", 10.0, 0.0)


def test_errors_up_and_down_do_not_cancel():
    by_turns = {k: [pointer(hover_mm=10.0 + 2.0 * (-1) ** k)] for k in range(COUNT)}
    trial = held(10.0, by_turns)
    assert (trial.error, trial.bias) == pytest.approx((2.0, 0.0))


def test_frames_without_a_pointer_give_no_reading_rather_than_accuracy():
    half = {k: [pointer(hover_mm=10.0)] if k % 2 else [] for k in range(COUNT)}
    trial = held(10.0, half)
    assert (trial.error, trial.no_reading) == pytest.approx((0.0, 0.5))
    silent = held(10.0, everywhere([]))
    assert np.isnan(silent.error)
    assert silent.no_reading == 1.0


def test_a_half_curled_finger_that_hangs_lower_is_not_the_held_one():
    hanging = finger(finger="middle", x_mm=125.0, height_mm=4.0)
    fingers = everywhere([finger(height_mm=10.0), hanging])
    reported = published_frames(COUNT, pointers=everywhere([pointer(hover_mm=9.0)]))
    trial = score_levels(reported, truth_of(truth_frames(COUNT, fingers)), [STEP])[0]
    assert (trial.error, trial.no_reading) == pytest.approx((1.0, 0.0))


def test_a_pointer_of_another_finger_gives_no_reading():
    assert held(10.0, everywhere([pointer(x_mm=150.0)])).no_reading == 1.0


@pytest.mark.parametrize(
    "reported, error",
    [
        ({"state": Touch.TOUCH, "force_g": 96.25}, 0.0),
        ({"state": Touch.TOUCH, "force_g": 96.25 + 38.5}, 10.0),
        ({"state": Touch.HOVER, "force_g": 0.0}, 25.0),
    ],
    ids=["exactly", "a tenth of 385 g too much", "in the air: nothing"],
)
def test_pressure_is_off_by_shares_of_385_g(reported, error):
    trial = held(0.0, everywhere([pointer(hover_mm=0.0, **reported)]), PRESS, force_g=96.25)
    assert trial.error == pytest.approx(error)


@pytest.mark.parametrize("state", [Touch.TOUCH, Touch.HOVER])
def test_a_pointer_without_a_force_gives_no_reading(state):
    silent = {"state": state, "hover_mm": 0.0, "force_g": -1.0}
    trial = held(0.0, everywhere([pointer(**silent)]), PRESS, force_g=96.25)
    assert np.isnan([trial.error, trial.bias, trial.reported]).all()
    assert trial.no_reading == 1.0
    half = {k: [pointer(**silent | ({"force_g": 96.25} if k % 2 else {}))] for k in range(COUNT)}
    trial = held(0.0, half, PRESS, force_g=96.25)
    assert trial.no_reading == pytest.approx(0.5)
    assert trial.error == pytest.approx(0.0 if state is Touch.TOUCH else 25.0)


def test_frames_outside_the_step_do_not_count():
    wrong_outside = everywhere([pointer(hover_mm=10.0)])
    wrong_outside |= {k: [pointer(hover_mm=99.0)] for k in (0, 1, 2, 20, 21)}
    step = STEP | {"from_s": 0.1, "to_s": 0.6}
    assert held(10.0, wrong_outside, step).error == 0.0


def test_a_jump_is_what_hover_changes_beyond_the_finger():
    heights = {k: 20.0 - k for k in range(10)}
    truth = truth_of(truth_frames(10, {k: [finger(height_mm=h)] for k, h in heights.items()}))
    reported = {k: [pointer(hover_mm=h + (5.0 if k >= 6 else 0.0))] for k, h in heights.items()}
    jumps = score_jumps(published_frames(10, pointers=reported), truth)
    assert [round(jump.jump_mm, 6) for jump in jumps] == [0.0] * 5 + [5.0] + [0.0] * 3
    assert jumps[5].height_mm == 14.0
