"""The story of one frame, told over many."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from halo_service.profile import Profile
from halo_service.sensing import SensingSettings, State, adopt, clear, start, step
from halo_service.values import Frame, Touch, TouchFrame, Tracked
from tests.drawn import PER_DENT_MM

FRAME_US = 33_333
Draw = Callable[..., Frame]
See = Callable[..., Tracked]


def play(
    profile: Profile, draw: Draw, see: See, signals: Sequence[float], late: int = 0
) -> tuple[list[TouchFrame], State]:
    """Play a finger at rest over one spot; its halo goes through `signals`, one a frame."""
    state = start(profile, SensingSettings())
    told = []
    for n, signal in enumerate(signals):
        frame = draw(signal=signal, height_mm=0.0, time_us=n * FRAME_US)
        result, state = step(state, frame, see(time_us=max(n - late, 0) * FRAME_US))
        told.append(result)
    return told, state


def dents(*depths_mm: int) -> list[float]:
    """Signals of dents this deep, mm; under the halo's threshold of 8 mm there is none."""
    return [depth * PER_DENT_MM for depth in depths_mm]


def kinds(told: Sequence[TouchFrame]) -> list[tuple[int, str]]:
    return [(n, event.kind) for n, frame in enumerate(told) for event in frame.events]


@pytest.fixture
def deep(profile: Profile) -> Profile:
    """The four states as patches 9, 10, 12 and 16 mm deep, which can be drawn; no round dents."""
    from dataclasses import replace

    assert profile.touch is not None
    levels = {"hover": 9, "subtle": 10, "touch": 12, "pressure": 16}
    states = {
        name: replace(getattr(profile.touch, name), signal=dents(deep)[0])
        for name, deep in levels.items()
    }
    return replace(profile, touch=replace(profile.touch, **states))


def test_a_tap_is_one_down_and_one_up(deep: Profile, draw: Draw, see: See) -> None:
    told, _ = play(deep, draw, see, dents(9, 9, 9, 12, 12, 12, 9, 9, 9))
    assert kinds(told) == [(3, "down"), (7, "up")]
    assert [frame.pointers[0].state for frame in told[3:7]] == [Touch.TOUCH] * 4
    assert told[-1].pointers[0].contacts == 1


def test_a_finger_that_only_hovers_never_touches(deep: Profile, draw: Draw, see: See) -> None:
    told, _ = play(deep, draw, see, dents(0, 9, 10, 9, 10, 10, 9, 0))
    assert kinds(told) == []


def test_a_dip_of_one_frame_is_no_second_touch(deep: Profile, draw: Draw, see: See) -> None:
    told, _ = play(deep, draw, see, dents(9, 9, 12, 12, 9, 12, 12, 9, 9))
    assert [kind for _, kind in kinds(told)] == ["down", "up"]


def test_each_of_many_taps_counts(deep: Profile, draw: Draw, see: See) -> None:
    told, _ = play(deep, draw, see, dents(9, 9, *(12, 12, 12, 9, 9, 9) * 5))
    assert [kind for _, kind in kinds(told)] == ["down", "up"] * 5
    assert told[-1].pointers[0].contacts == 5


def test_pressure_is_one_at_the_calibrated_press_and_goes_on(
    deep: Profile, draw: Draw, see: See
) -> None:
    told, _ = play(deep, draw, see, dents(9, 9, 12, 14, 16, 18))
    pressures = [frame.pointers[0].pressure for frame in told]
    assert pressures == pytest.approx([0.0, 0.0, 0.02, 0.4054, 1.0, 1.7567], abs=1e-4)
    assert [frame.pointers[0].force_g for frame in told[2:5]] == pytest.approx(
        [25.0, 95.9, 200.0], abs=0.1
    )


def test_the_down_frame_is_where_the_finger_is(deep: Profile, draw: Draw, see: See) -> None:
    told, _ = play(deep, draw, see, dents(9, 9, 12))
    pointer, event = told[-1].pointers[0], told[-1].events[0]
    assert (event.x_mm, event.y_mm) == (pointer.x_mm, pointer.y_mm)
    # The silhouette ends at (320, 288) px; the pad lies 7 mm behind it, at 500 mm less the finger.
    assert pointer.x_mm == pytest.approx(150.0, abs=2.0)
    assert pointer.y_mm == pytest.approx(107.0, abs=2.0)


def test_a_late_tracker_does_not_make_the_tip_late(deep: Profile, draw: Draw, see: See) -> None:
    state = start(deep, SensingSettings())
    for n in range(20):
        tip = (320.0 + 6.0 * n, 288.0)
        seen = see(tip=(320.0 + 6.0 * max(n - 2, 0), 288.0), time_us=max(n - 2, 0) * FRAME_US)
        told, state = step(state, draw(tip=tip, height_mm=20.0, time_us=n * FRAME_US), seen)
        if n > 2:
            assert told.pointers[0].diagnostics.tip_px[0] == pytest.approx(tip[0], abs=2.0)


@pytest.mark.parametrize("off", [(6.0, 0.0), (-6.0, 3.0), (0.0, 8.0), (4.0, -8.0)])
def test_landmarks_that_are_off_are_put_on_the_silhouette(
    deep: Profile, draw: Draw, see: See, off: tuple[float, float]
) -> None:
    told, _ = step(start(deep, SensingSettings()), draw(height_mm=20.0), see(off=off))
    assert told.pointers[0].diagnostics.tip_px == pytest.approx((320.0, 288.0), abs=2.0)


@pytest.mark.parametrize("height_mm", [20.0, 40.0, 80.0])
def test_above_the_halo_height_is_read_off_the_fingers_own_depth(
    deep: Profile, draw: Draw, see: See, height_mm: float
) -> None:
    told, _ = step(start(deep, SensingSettings()), draw(height_mm=height_mm), see())
    assert told.pointers[0].hover_mm == pytest.approx(height_mm, abs=1.0)
    assert told.pointers[0].pressure == 0.0


@pytest.mark.parametrize(
    ("tip", "height_mm"),
    [((320.0, 288.0), 130.0), ((560.0, 288.0), 20.0), ((320.0, 120.0), 20.0)],
    ids=["too high", "right of the surface", "beyond the far edge"],
)
def test_out_of_reach_is_no_pointer(
    deep: Profile, draw: Draw, see: See, tip: tuple[float, float], height_mm: float
) -> None:
    told, _ = step(start(deep, SensingSettings()), draw(tip, height_mm=height_mm), see(tip))
    assert told.pointers == ()


def test_a_hand_that_leaves_lets_its_touch_go(deep: Profile, draw: Draw, see: See) -> None:
    told, state = play(deep, draw, see, dents(9, 9, 12, 12))
    assert told[-1].pointers[0].state is Touch.TOUCH
    kinds_seen: list[str] = []
    for n in range(4, 14):
        frame = draw(tip=(320.0, 700.0), time_us=n * FRAME_US)
        result, state = step(state, frame, Tracked(n * FRAME_US, ()))
        kinds_seen += [event.kind for event in result.events]
    assert kinds_seen == ["up"]
    assert result.pointers == ()


def test_a_touch_that_the_depth_shows_outlives_a_tracker_that_lost_the_hand(
    deep: Profile, draw: Draw, see: See
) -> None:
    told, state = play(deep, draw, see, dents(9, 9, 12, 12))
    for n in range(4, 64):
        tip = (320.0 + 2.0 * n, 288.0)
        frame = draw(tip=tip, signal=dents(12)[0], time_us=n * FRAME_US)
        result, state = step(state, frame, Tracked(n * FRAME_US, ()))
        assert [pointer.state for pointer in result.pointers] == [Touch.TOUCH]
        assert result.pointers[0].diagnostics.tip_px[0] == pytest.approx(tip[0], abs=2.0)
    assert result.pointers[0].id == told[0].pointers[0].id


def test_a_frame_that_cannot_be_sensed_lets_all_go(deep: Profile, draw: Draw, see: See) -> None:
    _, state = play(deep, draw, see, dents(9, 9, 12, 12))
    told, state = clear(state, 4 * FRAME_US)
    assert told.pointers == ()
    assert [event.kind for event in told.events] == ["up"]
    assert clear(state, 5 * FRAME_US)[0].events == ()


def test_an_id_is_never_given_twice(deep: Profile, draw: Draw, see: See) -> None:
    told, state = play(deep, draw, see, dents(9, 9))
    first = told[-1].pointers[0]
    _, state = clear(state, 2 * FRAME_US)
    told_again, _ = step(state, draw(time_us=3 * FRAME_US), see(time_us=3 * FRAME_US))
    again = told_again.pointers[0]
    assert again.id > first.id
    assert again.slot == first.slot == 0


def test_without_a_profile_there_are_no_pointers(draw: Draw, see: See) -> None:
    told, _ = step(start(None, SensingSettings()), draw(), see())
    assert told.pointers == ()
    assert told.surface == "table"


def test_unmeasured_depth_is_neither_hand_nor_halo(deep: Profile, draw: Draw, see: See) -> None:
    frame = draw()
    blind = Frame(0, np.zeros_like(frame.depth), frame.ir)
    told, _ = step(start(deep, SensingSettings()), blind, see())
    assert all(pointer.diagnostics.halo == 0.0 for pointer in told.pointers)
    assert all(pointer.confidence < 0.5 for pointer in told.pointers)


def test_the_same_frames_give_the_same_story(deep: Profile, draw: Draw, see: See) -> None:
    signals = dents(0, 9, 10, 12, 16, 12, 9, 0)
    once, _ = play(deep, draw, see, signals, late=1)
    again, _ = play(deep, draw, see, signals, late=1)
    assert repr(once) == repr(again)  # nan equals nothing


def test_a_new_profile_lets_a_touch_go_with_its_up(
    profile: Profile, draw: Callable[..., Frame], see: Callable[..., Tracked]
) -> None:
    state = start(profile, SensingSettings())
    kinds: list[str] = []
    for n, signal in enumerate([0.0, 0.0, 2200.0, 2200.0, 2200.0, 2200.0, 2200.0]):
        if n == 4:
            state = adopt(state, replace(profile, revision=2))
        told, state = step(state, draw(signal=signal, time_us=n * 33_333), see(time_us=n * 33_333))
        kinds += [event.kind for event in told.events]
    assert kinds == ["down", "up"]
