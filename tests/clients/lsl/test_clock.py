"""Frame time on LSL's clock: exact on one machine, steady when clocks are set, else estimated."""

from __future__ import annotations

import random

import pytest

from halo_lsl.clock import Arrival, Clock, Kind

UNIX_S, LSL_S = 1_795_000_000.0, 4_000.0
"""Both clocks of this machine at the same moment."""


def arrival(at_s: float, unix_error_s: float = 0.0) -> Arrival:
    return Arrival(LSL_S + at_s, UNIX_S + at_s + unix_error_s)


def test_on_one_machine_the_delay_is_not_in_the_times() -> None:
    clock, delays = Clock(), random.Random(1)
    for n in range(100):
        delay_s = delays.uniform(0.03, 0.2)
        clock.read(UNIX_S + n / 30, arrival(n / 30 + delay_s))
        assert clock.to_lsl(UNIX_S + n / 30) == pytest.approx(LSL_S + n / 30, abs=1e-5)
        assert clock.pipeline_s == pytest.approx(delay_s, abs=1e-5)
    assert clock.kind is Kind.HOST


@pytest.mark.parametrize("jump_s", [-3600.0, -0.9, 0.3, 7.0])
def test_when_the_host_s_clock_is_set_no_sample_moves_by_a_millisecond(jump_s: float) -> None:
    """The service reports the jump up to a second later, and follows by 0.5 ms per second."""
    clock = Clock()
    frame_error_s = 0.0
    for n in range(30 * 30):
        at_s = n / 30
        jumped = at_s > 10.0
        if jumped:
            frame_error_s += min(abs(jump_s), 0.0005 / 30) * (1 if jump_s > 0 else -1)
        if n % 30 == 0:
            clock.report((jump_s if jumped else 0.0) - frame_error_s)
        frame_s = UNIX_S + at_s + frame_error_s
        clock.read(frame_s, arrival(at_s + 0.05, jump_s if jumped else 0.0))
        assert abs(clock.to_lsl(frame_s) - (LSL_S + at_s)) < 0.001


@pytest.mark.parametrize("error_s", [-30.0, 0.004, 7.0])
def test_a_host_s_clock_that_was_set_before_is_allowed_for_at_once(error_s: float) -> None:
    """The service has followed a part of the way; it says so a second after the first frame."""
    clock = Clock()
    for n in range(60):
        frame_s = UNIX_S + n / 30 - error_s
        if n == 30:
            clock.report(error_s)
        clock.read(frame_s, arrival(n / 30 + 0.05))
        if n >= 30:
            assert clock.to_lsl(frame_s) == pytest.approx(LSL_S + n / 30, abs=1e-5)
    assert clock.kind is Kind.HOST


def test_a_restarted_service_has_no_error_of_the_one_before() -> None:
    clock = Clock()
    clock.report(7.0)
    clock.read(UNIX_S - 7.0, arrival(0.05))
    clock.restart()
    clock.read(UNIX_S + 1.0, arrival(1.05))
    assert clock.to_lsl(UNIX_S + 1.0) == pytest.approx(LSL_S + 1.0, abs=1e-5)


def test_a_clock_of_another_machine_is_read_off_the_fastest_arrivals() -> None:
    clock, delays = Clock(delay_s=0.040), random.Random(2)
    for n in range(300):
        clock.read(77.0 + n / 30, arrival(n / 30 + 0.040 + delays.uniform(0.0, 0.030)))
    assert clock.kind is Kind.ARRIVAL
    assert clock.to_lsl(77.0) == pytest.approx(LSL_S, abs=0.001)


def test_another_session_starts_the_estimate_afresh() -> None:
    clock = Clock(Kind.ARRIVAL)
    clock.read(77.0, arrival(0.0))
    clock.restart()
    with pytest.raises(ValueError, match="no frame was read"):
        clock.to_lsl(77.0)
    clock.read(5.0, arrival(1.0))
    assert clock.to_lsl(5.0) == pytest.approx(LSL_S + 1.0)
