"""The camera's time in the host's: a table of clocks and delays, no waiting."""

from collections.abc import Iterator

import numpy as np
import pytest

from halo_service.sources.clock import DeviceClock

PERIOD_US = 33_333
START_US = 1_795_332_989_000_000
LEAST_DELAY_US = 12_000


def arrivals(frames: int, *, drift=0.0, jitter_us=8000.0, seed=0) -> Iterator[tuple[int, int, int]]:
    """(device time, true Unix time, time of arrival) of each frame, us."""
    rng = np.random.default_rng(seed)
    for n in range(frames):
        true_us = START_US + n * PERIOD_US
        device_us = round(5_000_000 + n * PERIOD_US * (1 + drift))
        delay_us = LEAST_DELAY_US + rng.exponential(jitter_us)
        yield device_us, true_us, round(true_us + delay_us)


def errors_us(frames, clock: DeviceClock | None = None) -> np.ndarray:
    """How far from the truth, less the least delay, which cannot be measured."""
    clock = clock or DeviceClock()
    return np.array(
        [clock.unix_us(device, arrived) - true - LEAST_DELAY_US for device, true, arrived in frames]
    )


def test_delays_that_differ_do_not_shake_the_time():
    errors = errors_us(arrivals(900))
    assert np.abs(errors[30:]).max() < 2000
    assert np.abs(np.diff(errors[60:])).max() <= 20


@pytest.mark.parametrize("drift", [-100e-6, -20e-6, 20e-6, 100e-6])
def test_a_crystal_that_drifts_is_followed_for_an_hour(drift):
    errors = errors_us(arrivals(108_000, drift=drift))
    assert np.abs(errors[300:]).max() < 3000


def test_a_second_of_late_frames_changes_nothing():
    frames = list(arrivals(600))
    late = [(d, t, a + (300_000 if 300 <= n < 330 else 0)) for n, (d, t, a) in enumerate(frames)]
    np.testing.assert_allclose(errors_us(late), errors_us(frames), atol=200)


@pytest.mark.parametrize("seed", range(5))
def test_time_rises_with_every_frame(seed):
    clock = DeviceClock()
    times = [clock.unix_us(d, a) for d, _, a in arrivals(400, jitter_us=60_000, seed=seed)]
    assert (np.diff(times) > 0).all()


@pytest.mark.parametrize("hours", [-1, 1])
def test_a_host_clock_that_is_set_is_followed_and_time_goes_on(hours):
    set_us = hours * 3_600_000_000
    clock = DeviceClock()
    errors_us = []
    for n, (device_us, true_us, arrived_us) in enumerate(arrivals(1200)):
        moved_us = set_us if n >= 400 else 0
        errors_us.append(clock.unix_us(device_us, arrived_us + moved_us) - true_us - moved_us)
    # At once when time is set back; set forward it might be a delay, until all are that late.
    assert np.abs(np.array(errors_us[720:]) - LEAST_DELAY_US).max() < 3000
    assert (np.diff(errors_us[720:]) > -PERIOD_US).all()


def test_a_device_time_of_zero_is_a_time():
    clock = DeviceClock()
    assert clock.unix_us(0, START_US) == START_US
    assert clock.unix_us(0, START_US) == START_US
