"""Time lines: continuous, exact at contact, and alive in between."""

import numpy as np
import pytest

from halo_service.values import Side
from halo_service.virtual.motion import (
    Timeline,
    bump,
    plateau,
    smooth,
    smooth_speed,
)
from halo_service.virtual.skeleton import FingerPose
from halo_service.virtual.timeline import TimelineReader

START = FingerPose(100.0, 100.0, 20.0)


def timeline(seed=1):
    return Timeline(np.random.default_rng(seed), START, Side.RIGHT)


def track(script, seed=1):
    motion = timeline(seed)
    return motion, TimelineReader(script(motion), np.random.default_rng(seed))


def test_minimum_jerk_starts_and_ends_at_rest():
    assert (smooth(0.0), smooth(0.5), smooth(1.0)) == (0.0, 0.5, 1.0)
    assert smooth_speed(0.0) == smooth_speed(1.0) == 0.0
    shares = np.linspace(0.01, 0.99, 50)
    slope = [(smooth(s + 1e-6) - smooth(s - 1e-6)) / 2e-6 for s in shares]
    assert slope == pytest.approx([smooth_speed(s) for s in shares], rel=1e-5)


def taps(p):
    yield from p.reach(0.5, x_mm=150.0, height_mm=18.0)
    for _ in range(3):
        yield from p.tap(0.2, 60.0, lift_mm=15.0)
        yield from p.hold(0.2)


def test_a_tap_meets_the_table_with_speed_and_at_the_given_time():
    _, line = track(taps)
    times = np.arange(0.0, 2.5, 0.001)
    poses = [line.at(t) for t in times]
    contacts = line.started_contacts(10.0)
    assert len(contacts) == 3
    for contact in contacts:
        before, after = (np.searchsorted(times, contact.from_s + d) for d in (-0.004, 0.004))
        assert poses[before].height_mm > 0.2
        assert poses[before].force_g == 0.0
        assert poses[after].height_mm == 0.0
        assert poses[after].force_g > 0.0
        assert 60.0 < contact.strike_mm_s < 600.0
        assert contact.to_s - contact.from_s == pytest.approx(0.2)
        down = [p for t, p in zip(times, poses, strict=True) if contact.from_s <= t < contact.to_s]
        assert all(p.height_mm == 0.0 and p.force_g > 0.0 for p in down)
        assert max(p.force_g for p in down) == pytest.approx(contact.peak_force_g, rel=0.03)


def test_a_finger_never_jumps():
    _, line = track(taps)
    poses = [line.at(t) for t in np.arange(0.0, 2.5, 0.002)]
    for field in ("x_mm", "y_mm", "height_mm"):
        steps = np.abs(np.diff([getattr(p, field) for p in poses]))
        assert steps.max() < 1.6  # 0.8 m/s


def test_a_finger_in_the_air_trembles_and_one_on_the_table_does_not():
    def still(p):
        yield from p.hold(2.0)
        yield from p.strike(0.1)
        yield from p.press(2.0, plateau(50.0))

    _, line = track(still)
    air = [line.at(t).height_mm for t in np.arange(0.0, 2.0, 0.01)]
    assert 0.05 < np.std(air) < 1.0
    table = [line.at(t).height_mm for t in np.arange(2.2, 4.0, 0.01)]
    assert set(table) == {0.0}


@pytest.mark.parametrize("free_s", [0.06, 0.1, 0.3, 1.0, 5.0])
def test_a_timed_tap_is_on_time_even_with_little_time(free_s):
    def script(p):
        yield from p.hold(1.0)
        yield from p.tap_at(1.0 + free_s, 0.1, bump(50.0), 15.0, to={"x_mm": 180.0})

    _, line = track(script)
    line.at(1.0 + free_s + 0.2)
    (contact,) = line.started_contacts(99.0)
    assert contact.from_s == pytest.approx(1.0 + free_s, abs=1e-9)
    assert contact.x_mm == 180.0


def test_a_reach_that_is_too_short_is_refused():
    with pytest.raises(ValueError, match="a finger cannot get there"):
        list(timeline().tap_at(0.01, 0.1, bump(50.0), 15.0))


def test_steps_are_named_when_they_are_done():
    motion = timeline()
    list(motion.step("hover", motion.hold(2.0), height_mm=10.0))
    (step,) = motion.steps
    assert (step.name, step.from_s, step.to_s, step.fields) == (
        "hover",
        0.0,
        2.0,
        {"height_mm": 10.0},
    )


def test_an_ended_timeline_stays_at_its_last_pose():
    _, line = track(lambda p: p.reach(0.5, height_mm=30.0))
    assert line.at(0.4).height_mm < 30.0
    assert not line.finished
    assert line.at(8.0).height_mm == pytest.approx(30.0, abs=1.0)
    assert line.finished
