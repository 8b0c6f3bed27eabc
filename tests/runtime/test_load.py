"""When the hand tracker gets fewer frames."""

import pytest

from halo_service.runtime.health import HealthCounter
from halo_service.runtime.load import CALM, LEVELS, LOOK_US, MOST_LATE, WINDOW, LoadWatch

PERIOD_S = 1 / 30


def run(watch: LoadWatch, frames: int, *, spent_s: float = 0.004, **frame: float) -> None:
    """Count frames that are alike."""
    frame_of = {"waited_s": 0.02, "missed": 0, "period_s": PERIOD_S} | frame
    for _ in range(frames):
        watch.see(spent_s=spent_s, **frame_of)


def test_quick_frames_are_no_load_and_a_few_late_ones_neither() -> None:
    watch = LoadWatch()
    for _ in range(10):
        run(watch, WINDOW)
        run(watch, MOST_LATE - 1, spent_s=0.03)
        assert watch.level == 0


def test_frames_the_camera_drops_are_no_load() -> None:
    watch = LoadWatch()
    run(watch, 100, missed=1)  # the loop waits for each: it has time
    assert watch.level == 0


def test_late_packets_or_frames_that_wait_raise_the_level_step_by_step() -> None:
    for late in ({"spent_s": 0.03}, {"missed": 1, "waited_s": 0.0}):
        watch, levels = LoadWatch(), []
        for _ in range(10 * MOST_LATE):
            run(watch, 1, **late)
            levels.append(watch.level)
        assert levels.index(1) == MOST_LATE - 1 and levels.index(2) == 2 * MOST_LATE - 1
        assert levels[-1] == len(LOOK_US) - 1 == len(LEVELS) - 1


def test_the_level_falls_one_by_one_after_calm_seconds() -> None:
    watch = LoadWatch()
    run(watch, 2 * MOST_LATE, spent_s=0.03)
    assert watch.level == 2
    run(watch, CALM - 1)
    assert watch.level == 2
    run(watch, 1)
    assert watch.level == 1
    run(watch, CALM)
    assert watch.level == 0


@pytest.mark.parametrize(
    ("level", "drops_each", "says"),
    [(0, 0, "none"), (0, 1, "none"), (1, 1, "reduced"), (2, 0, "least"), (2, 1, "dropping")],
)
def test_health_says_what_is_left_out(level: int, drops_each: int, says: str) -> None:
    counter = HealthCounter()
    for number in range(11):
        counter.sent(number / 30.0, number / 30.0 + 0.005, 33_000, looks=100 + number // 2)
        counter.drops += drops_each
    health = counter.health(11 / 30.0, "tracking", level)
    assert health.load == says
    assert health.looks_hz == pytest.approx(15.0)


def test_the_rate_of_looks_is_unknown_without_a_hand_model_or_a_frame() -> None:
    counter = HealthCounter()
    assert counter.health(0.0, "searching").looks_hz == -1.0
    for number in range(3):
        counter.sent(number / 30.0, number / 30.0 + 0.005, None)
    assert counter.health(0.1, "off").looks_hz == -1.0
    assert counter.health(0.1, "searching").looks_hz == 0.0
