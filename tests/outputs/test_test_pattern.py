"""The test pattern follows from the time alone, and reads as a finger does."""

from __future__ import annotations

import math

import pytest

from halo_service.outputs.test_pattern import (
    HIGHEST_MM,
    LEAST_PRESSURE,
    RADIUS_SHARE,
    TOUCH_S,
    TURN_S,
    Pattern,
)
from halo_service.values import Touch, TouchFrame

PATTERN = Pattern("desk", 400.0, 250.0, pointer_id=9)


def frames(*times_s: float) -> list[TouchFrame]:
    befores = (-1.0, *times_s)
    return [
        PATTERN.frame(t_s, before_s, round(1e6 * t_s))
        for t_s, before_s in zip(times_s, befores, strict=False)
    ]


def test_the_pointer_stays_on_a_circle_and_moves_as_its_speed_states() -> None:
    step_s = 0.001
    for t_s in (0.0, 0.7, 2.9, 3.5, 401.3):
        here, there = (frame.pointers[0] for frame in frames(t_s, t_s + step_s))
        away = math.hypot(here.x_mm - 200.0, here.y_mm - 125.0)
        assert away == pytest.approx(RADIUS_SHARE * 250.0)
        assert (there.x_mm - here.x_mm) / step_s == pytest.approx(here.vx_mm_s, abs=0.5)
        assert (there.y_mm - here.y_mm) / step_s == pytest.approx(here.vy_mm_s, abs=0.5)


def test_it_touches_and_hovers_in_each_circle() -> None:
    for n in range(400):
        t_s = n / 30.0
        (pointer,) = frames(t_s)[0].pointers
        touching = t_s % TURN_S < TOUCH_S
        assert (pointer.state is Touch.TOUCH) == touching
        assert (pointer.hover_mm == 0.0) == touching or pointer.hover_mm < 1e-9
        assert (pointer.pressure >= LEAST_PRESSURE) == touching
        assert 0.0 <= pointer.hover_mm <= HIGHEST_MM
        assert pointer.contacts == t_s // TURN_S + 1


@pytest.mark.parametrize("rate_hz", [3.0, 29.97, 240.0])
def test_each_touch_begins_and_ends_once_at_any_rate(rate_hz: float) -> None:
    times_s = [n / rate_hz for n in range(round(20.5 * rate_hz))]
    events = [event for frame in frames(*times_s) for event in frame.events]
    expected = [(kind, turn) for turn in range(1, 6) for kind in ("down", "up")]
    assert [(event.kind, event.contacts) for event in events] == [*expected, ("down", 6)]
    assert all(0.0 <= event.ago_ms <= 1000.0 / rate_hz + 1e-6 for event in events)
