"""The filter of a fingertip's place against what it must give."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halo_service.sensing.kalman import Kalman, born, carried, corrected, distance, predicted

FRAME_US = 33_333


def moving(speed_mm_s: float, frames: int = 10, sigma_mm: float = 1.0) -> Kalman:
    """Return the state of a finger that was measured in so many frames."""
    state = born(0, (0.0, 0.0), sigma_mm)
    for n in range(1, frames):
        place = (speed_mm_s * n * FRAME_US / 1e6, 0.0)
        state = corrected(predicted(state, n * FRAME_US), place, sigma_mm)
    return state


@pytest.mark.parametrize("speed_mm_s", [0.0, 100.0, 900.0])
def test_a_constant_velocity_is_followed_without_lag(speed_mm_s: float) -> None:
    state = predicted(moving(speed_mm_s), 10 * FRAME_US)
    assert state.velocity_mm_s == pytest.approx((speed_mm_s, 0.0), abs=1.0 + 0.01 * speed_mm_s)
    assert state.place_mm[0] == pytest.approx(speed_mm_s * 10 * FRAME_US / 1e6, abs=0.5)


def test_without_a_measurement_a_place_grows_uncertain_and_stays_near() -> None:
    state = moving(900.0)
    ahead = [predicted(state, state.time_us + n * FRAME_US) for n in (0, 1, 2, 8)]
    sigmas = [math.sqrt(each.place_mm2) for each in ahead]
    assert sigmas[0] < 1.0 and sigmas[1] < 15.0 and sigmas[3] > 50.0
    assert ahead[3].place_mm[0] - state.place_mm[0] < 0.08 * 900.0  # it may have stopped


def test_a_measurement_counts_by_its_variance() -> None:
    state = predicted(moving(0.0), 10 * FRAME_US)
    exact, rough = (corrected(state, (10.0, 0.0), sigma) for sigma in (1.0, 8.0))
    assert exact.place_mm[0] == pytest.approx(10.0, abs=0.5)
    assert 2.0 < rough.place_mm[0] < 6.0
    assert exact.place_mm2 < rough.place_mm2 < state.place_mm2


def test_two_steps_of_a_prediction_are_one() -> None:
    state = moving(300.0)
    at_once = predicted(state, state.time_us + FRAME_US)
    half = predicted(state, state.time_us + FRAME_US // 2)
    in_two = predicted(half, state.time_us + FRAME_US)
    for name in ("place_mm", "place_mm2", "both_mm2_s", "velocity_mm2_s2"):
        assert getattr(in_two, name) == pytest.approx(getattr(at_once, name))


def test_the_distance_is_in_standard_deviations() -> None:
    random = np.random.default_rng(3)
    state = born(0, (0.0, 0.0), 4.0)
    places = random.normal(0.0, 5.0, (4000, 2))  # 3 of the measurement and 4 of the state
    away = [distance(state, (float(x), float(y)), 3.0) for x, y in places]
    assert np.mean(np.square(away)) == pytest.approx(2.0, rel=0.1)


def test_a_measured_way_moves_a_resting_finger_at_once() -> None:
    state = carried(moving(0.0), 10 * FRAME_US, (24.0, 0.0), 1.0)
    assert state.place_mm == pytest.approx((24.0, 0.0), abs=2.0)
    assert state.velocity_mm_s[0] > 600.0
    assert math.sqrt(state.place_mm2) < 2.0


def test_a_measured_way_keeps_what_was_uncertain_before_it() -> None:
    """It says how far a finger went, not where it is."""
    state = carried(born(0, (0.0, 0.0), 8.0), FRAME_US, (24.0, 0.0), 1.0)
    assert math.sqrt(state.place_mm2) == pytest.approx(8.0, abs=0.2)


def test_a_vague_way_changes_no_prediction() -> None:
    ahead = predicted(moving(900.0), 10 * FRAME_US)
    state = carried(moving(900.0), 10 * FRAME_US, (-50.0, 50.0), 1e6)
    assert state.place_mm == pytest.approx(ahead.place_mm, abs=1e-3)
    assert state.place_mm2 == pytest.approx(ahead.place_mm2)
    assert state.velocity_mm2_s2 == pytest.approx(ahead.velocity_mm2_s2)
