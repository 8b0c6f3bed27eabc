"""Strike speeds and velocities. Each figure has a known answer."""

import numpy as np
import pytest

from halo_service.evaluation.metrics.speeds import (
    Speed,
    rank_correlation,
    relative_error,
    score_strikes,
    score_velocity,
)
from halo_service.evaluation.metrics.touches import score_touches
from tests.evaluation.small_world import (
    COUNT,
    FRAME_US,
    contact,
    down,
    finger,
    pointer,
    published_frames,
    truth_frames,
    truth_of,
)


def test_the_strike_error_is_a_share_of_the_true_speed():
    lines = [contact(5, 8), contact(15, 18, strike_mm_s=400.0)]
    downs = {5: [down(strike_mm_s=150.0)], 15: [down(strike_mm_s=300.0)]}
    truth = truth_of([*truth_frames(COUNT), *lines])
    speeds = score_strikes(score_touches(published_frames(COUNT, downs), truth).hits)
    assert relative_error(speeds) == pytest.approx(0.25)


def test_ranks_need_enough_and_something_to_rank():
    rising = [Speed(float(k), float(k**2), 0.0) for k in range(1, 8)]
    assert rank_correlation(rising) == pytest.approx(1.0)
    assert np.isnan(rank_correlation(rising[:4]))
    assert np.isnan(rank_correlation([Speed(1.0, float(k), 0.0) for k in range(9)]))


def test_velocity_is_compared_with_the_true_path():
    step_mm = 300.0 * FRAME_US / 1e6
    truth = truth_of(truth_frames(10, {k: [finger(100.0 + step_mm * k)] for k in range(10)}))
    reported = {k: [pointer(x_mm=100.0 + step_mm * k, vx_mm_s=240.0)] for k in range(10)}
    speeds = score_velocity(published_frames(10, pointers=reported), truth)
    assert len(speeds) == 8  # the ends have no neighbours
    assert relative_error(speeds) == pytest.approx(0.2, abs=1e-3)
    sideways = {k: [pointer(x_mm=100.0 + step_mm * k, vy_mm_s=300.0)] for k in range(10)}
    assert relative_error(score_velocity(published_frames(10, pointers=sideways), truth)) > 1.0
