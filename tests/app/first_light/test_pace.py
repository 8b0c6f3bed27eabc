"""When a task is done, by a table of what the finger does; no rendering, no waiting."""

from __future__ import annotations

from dataclasses import replace

import pytest

from halo_calibration.observe import Observation
from halo_service.app.first_light.pace import HOLD_S, SETTLED_S, Pace, State
from halo_service.values import Side

FRAME_US = 33_333
TOUCH_RAW = 1000.0
FINGER = Observation(0, Side.RIGHT, 100.0, 100.0, 45.0, 0.0, 12.0, 0.0, 0.0, 0)


def at(raw: float, x_mm: float = 100.0) -> Observation:
    return replace(FINGER, raw=raw, x_mm=x_mm)


def run(pace: Pace, *parts: tuple[float, Observation | None], start_us: int = 0) -> int:
    """Show each observation for so many seconds; return the time after the last."""
    now_us = start_us
    for seconds, seen in parts:
        for _ in range(round(seconds * 1e6 / FRAME_US)):
            if pace.state in (State.DONE, State.MISSED):
                return now_us
            pace.feed(now_us, seen)
            now_us += FRAME_US
    return now_us


TOUCHES = {
    "comes, touches, lifts": ([(1.0, at(50)), (0.5, at(900)), (0.5, at(100))], State.DONE),
    "touches and leaves the view": ([(0.5, at(900)), (0.5, None)], State.DONE),
    "a tap of two frames": ([(0.5, at(20)), (0.07, at(800)), (0.5, at(50))], State.DONE),
    "is lost for a frame while it rests": (
        [(0.3, at(900)), (0.04, None), (0.3, at(900))],
        State.DOWN,
    ),
    "rests for too long": ([(9.0, at(900))], State.DONE),
    "hovers and is never felt": ([(20.0, at(200))], State.MISSED),
    "no hand at all is a pause": ([(60.0, None)], State.WAITING),
    "a pause does not count as patience": (
        [(5.0, at(20)), (60.0, None), (2.0, at(20))],
        State.WAITING,
    ),
}


@pytest.mark.parametrize(("parts", "state"), TOUCHES.values(), ids=TOUCHES)
@pytest.mark.parametrize("kind", ["touch", "tap"])
def test_a_touch_is_done_when_the_finger_was_down_and_left(kind, parts, state) -> None:
    pace = Pace(kind, TOUCH_RAW)
    run(pace, *parts)
    assert pace.state is state


def test_a_touch_lasts_from_where_it_was_felt_to_where_it_left() -> None:
    pace = Pace("touch", TOUCH_RAW)
    run(pace, (1.0, at(50)), (0.5, at(900)), (1.0, at(100)))
    assert pace.from_us / 1e6 == pytest.approx(1.0, abs=0.04)
    assert pace.to_us / 1e6 == pytest.approx(1.5, abs=0.04)


@pytest.mark.parametrize("kind", ["hover", "pressure"])
def test_a_level_is_measured_once_the_finger_is_still(kind) -> None:
    pace = Pace(kind, TOUCH_RAW)
    raw = 150.0 if kind == "hover" else 1400.0
    moving = [(0.1, at(raw, x_mm=100.0 + 3.0 * step)) for step in range(20)]
    run(pace, *moving, (SETTLED_S[kind] + HOLD_S + 0.5, at(raw)))
    assert pace.state is State.DONE
    assert (pace.to_us - pace.from_us) / 1e6 == pytest.approx(HOLD_S, abs=0.04)
    assert pace.from_us / 1e6 > 2.0 + 0.8 * SETTLED_S[kind], "the moving finger was not measured"


def test_a_finger_that_moves_while_it_is_measured_is_asked_again() -> None:
    pace = Pace("hover", TOUCH_RAW)
    settle = SETTLED_S["hover"] + 0.1
    now_us = run(pace, (settle, at(150)))
    assert pace.state is State.HOLDING
    now_us = run(pace, (0.4, at(150)), (HOLD_S, at(150, x_mm=150.0)), start_us=now_us)
    assert pace.again == 1
    run(pace, (settle + HOLD_S + 0.5, at(150, x_mm=150.0)), start_us=now_us)
    assert pace.state is State.DONE


def test_a_press_that_touches_nothing_is_not_measured() -> None:
    pace = Pace("pressure", TOUCH_RAW)
    run(pace, (10.0, at(100)))
    assert pace.state is State.WAITING
    run(pace, (60.0, at(100)), start_us=10_000_000)
    assert pace.state is State.MISSED


def test_a_finger_that_never_holds_still_is_given_up_after_a_while() -> None:
    pace = Pace("hover", TOUCH_RAW)
    run(pace, *((0.05, at(150, x_mm=100.0 + 20.0 * (step % 2))) for step in range(600)))
    assert pace.state is State.MISSED
