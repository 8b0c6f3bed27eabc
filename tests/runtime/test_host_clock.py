"""Time in frames does not jump when the host's clock does."""

from __future__ import annotations

import logging
from itertools import pairwise

import pytest

from halo_service.host_clock import CLOCK, HostClock

START_NS = 1_700_000_000_000_000_000
FRAME_NS = 33_333_333


class Host:
    """A machine: its monotonic clock, and its Unix clock, which can be set."""

    def __init__(self) -> None:
        self.monotonic_ns = 5_000_000_000
        self.set_by_ns = 0
        self.drift = 0.0
        self.clock = HostClock(self.unix_ns, lambda: self.monotonic_ns)

    def unix_ns(self) -> int:
        return START_NS + round(self.monotonic_ns * (1 + self.drift)) + self.set_by_ns

    def frames(self, count: int) -> list[int]:
        times = []
        for _ in range(count):
            self.monotonic_ns += FRAME_NS
            times.append(self.clock.unix_us())
        return times


@pytest.mark.parametrize("set_by_s", [-30, 30, -0.2, 3600])
def test_a_set_clock_changes_no_interval_and_is_counted(
    set_by_s: float, caplog: pytest.LogCaptureFixture
) -> None:
    host = Host()
    before = host.frames(300)
    host.set_by_ns = round(set_by_s * 1e9)
    with caplog.at_level(logging.WARNING):
        after = host.frames(300)
    intervals = [b - a for a, b in pairwise(before + after)]
    assert all(abs(interval - 33_333) <= 33_333 * 500e-6 + 2 for interval in intervals)
    assert host.clock.jumps == 1
    assert host.clock.error_ms == pytest.approx(set_by_s * 1000, abs=6.0)
    (record,) = caplog.records
    assert f"set by {set_by_s:+.1f} s" in record.getMessage()


def test_it_reaches_the_new_time() -> None:
    host = Host()
    host.frames(2)
    host.set_by_ns = -200_000_000
    host.frames(30 * 500)  # 500 s correct 250 ms
    assert abs(host.clock.error_ms) < 0.1
    assert host.clock.jumps == 1


def test_a_drift_is_followed_and_is_no_jump() -> None:
    host = Host()
    host.drift = 50e-6
    host.clock = HostClock(host.unix_ns, lambda: host.monotonic_ns)
    host.frames(30 * 600)
    assert abs(host.clock.error_ms) < 0.1
    assert host.clock.jumps == 0


def test_the_real_clock_goes_forward() -> None:
    times = [CLOCK.unix_us() for _ in range(1000)]
    assert times == sorted(times)
    assert CLOCK.jumps == 0
