"""Offset and drift of a clock come out of arrival times alone."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.canvas.clocks import Clock, line_under

START_US = 1_700_000_000_000_000
PERIOD_US = 33_333


def arrivals(
    seconds: float, offset_us: float, drift: float, seed: int = 1, start_us: int = START_US
) -> list[tuple[int, int]]:
    """(time on the node's clock, arrival on the canvas's) of frames, with jitter of 0 to 20 ms."""
    random = np.random.default_rng(seed)
    pairs = []
    for number in range(int(seconds * 1e6 / PERIOD_US)):
        true_us = start_us + number * PERIOD_US
        sent_us = true_us + offset_us + drift * (true_us - START_US)
        delay_us = 4000 + random.gamma(0.7, 3000) + (random.random() < 0.02) * 40_000
        pairs.append((round(sent_us), round(true_us + delay_us)))
    return pairs


@pytest.mark.parametrize(("offset_s", "drift"), [(0.0, 0.0), (5.0, 80e-6), (-3600.0, -500e-6)])
def test_a_clock_that_is_off_and_drifts_is_aligned(offset_s: float, drift: float) -> None:
    clock = Clock()
    pairs = arrivals(60.0, offset_s * 1e6, drift)
    here_us = [clock.arrived(*pair) for pair in pairs]
    true_us = START_US + np.arange(len(pairs)) * PERIOD_US
    # The shortest delay, 4 ms, cannot be distinguished from the offset.
    late_us = np.array(here_us) - true_us - 4000
    assert np.abs(late_us[300:]).max() < 2000
    assert clock.fit is not None
    assert abs(clock.fit.drift + drift) < 40e-6
    assert clock.fit.deviation_us < 2000
    assert clock.restarts == 0


def test_what_the_node_needs_itself_is_subtracted() -> None:
    clock = Clock()
    clock.latency_us = 4000.0
    pairs = arrivals(10.0, 0.0, 0.0)
    here_us = [clock.arrived(*pair) for pair in pairs]
    assert abs(here_us[-1] - START_US - (len(pairs) - 1) * PERIOD_US) < 1000


@pytest.mark.parametrize("step_s", [-5.0, -0.1, 0.1, 5.0])
def test_a_clock_that_is_set_starts_afresh(step_s: float) -> None:
    clock = Clock()
    for pair in arrivals(20.0, 0.0, 0.0):
        clock.arrived(*pair)
    later_us = START_US + 20_000_000
    pairs = arrivals(10.0, step_s * 1e6, 0.0, 2, later_us)
    here_us = [clock.arrived(*pair) for pair in pairs]
    true_us = later_us + (len(pairs) - 1) * PERIOD_US
    assert abs(here_us[-1] - true_us - 4000) < 5000
    assert clock.restarts == 1


def test_a_network_that_pauses_moves_no_clock() -> None:
    clock = Clock()
    pairs = arrivals(30.0, 0.0, 0.0)
    pause_us = START_US + 20_000_000
    for sent_us, arrival_us in pairs:
        paused = 0 <= sent_us - pause_us < 1_500_000
        here_us = clock.arrived(sent_us, pause_us + 1_505_000 if paused else arrival_us)
        assert sent_us < START_US + 1_000_000 or abs(here_us - sent_us - 4000) < 2000
    assert clock.restarts == 0


def test_times_never_go_back() -> None:
    clock = Clock()
    here_us = [clock.arrived(*pair) for pair in arrivals(60.0, 0.0, 100e-6)]
    assert (np.diff(here_us) > 0).all()


def test_the_line_is_below_all_points_and_touches_two() -> None:
    random = np.random.default_rng(3)
    points = [
        (second * 500_000, int(1000 + 50e-6 * second * 500_000 + random.exponential(2000)))
        for second in range(60)
    ]
    fit = line_under(points)
    over = np.array([delay_us - fit.delay_at(sent_us) for sent_us, delay_us in points])
    assert over.min() > -1.0
    assert np.count_nonzero(over < 1.0) >= 2
