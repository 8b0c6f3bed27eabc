"""One frame after the other through `step`, over a drawn table in each view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from halo_service.sensing import SensingSettings, State, adopt, clear, start, step
from halo_service.values import Frame, Touch, TouchFrame, Tracked
from tests.drawn import FRAME_US, MIDDLE, DrawnTable


def sense(
    table: DrawnTable, dents: Sequence[float], late: int = 0
) -> tuple[list[TouchFrame], State]:
    """Sense a finger at rest over one spot, around which the dent is so deep, mm, a frame each."""
    state = start(table.profile, SensingSettings())
    frames = []
    for n, dent_mm in enumerate(dents):
        frame = table.frame(dent_mm=dent_mm, time_us=n * FRAME_US)
        result, state = step(state, frame, table.hands(time_us=max(n - late, 0) * FRAME_US))
        frames.append(result)
    return frames, state


def once(
    table: DrawnTable, at_mm: tuple[float, float] = MIDDLE, height_mm: float = 0.0
) -> TouchFrame:
    """Sense a single frame."""
    state = start(table.profile, SensingSettings())
    return step(state, table.frame(at_mm, height_mm=height_mm), table.hands(at_mm))[0]


def kinds(frames: Sequence[TouchFrame]) -> list[tuple[int, str]]:
    return [(n, event.kind) for n, frame in enumerate(frames) for event in frame.events]


def test_a_tap_is_one_down_and_one_up(table: DrawnTable) -> None:
    frames, _ = sense(table, (9, 9, 9, 12, 12, 12, 9, 9, 9))
    assert kinds(frames) == [(3, "down"), (7, "up")]
    assert [frame.pointers[0].state for frame in frames[3:7]] == [Touch.TOUCH] * 4
    assert frames[-1].pointers[0].contacts == 1


def test_a_finger_that_only_hovers_never_touches(table: DrawnTable) -> None:
    frames, _ = sense(table, (0, 9, 10, 9, 10, 10, 9, 0))
    assert kinds(frames) == []


def test_a_dip_of_one_frame_is_no_second_touch(table: DrawnTable) -> None:
    frames, _ = sense(table, (9, 9, 12, 12, 9, 12, 12, 9, 9))
    assert [kind for _, kind in kinds(frames)] == ["down", "up"]


def test_each_of_many_taps_counts(table: DrawnTable) -> None:
    frames, _ = sense(table, (9, 9, *(12, 12, 12, 9, 9, 9) * 5))
    assert [kind for _, kind in kinds(frames)] == ["down", "up"] * 5
    assert frames[-1].pointers[0].contacts == 5


def test_pressure_is_one_at_the_calibrated_press_and_goes_on(table: DrawnTable) -> None:
    frames, _ = sense(table, (9, 9, 12, 14, 16, 18))
    pressures = [frame.pointers[0].pressure for frame in frames]
    # By the halo alone 0.4054 and 1.7567: what is known before moves both a little towards 1.
    assert pressures == pytest.approx([0.0, 0.0, 0.02, 0.4060, 1.0, 1.7547], abs=1e-4)
    assert [frame.pointers[0].force_g for frame in frames[2:5]] == pytest.approx(
        [25.0, 96.0, 200.0], abs=0.1
    )


def test_the_down_frame_is_where_the_finger_is(table: DrawnTable) -> None:
    frames, _ = sense(table, (9, 9, 12))
    pointer, event = frames[-1].pointers[0], frames[-1].events[0]
    assert (event.x_mm, event.y_mm) == (pointer.x_mm, pointer.y_mm)
    # The pad lies a fingertip's radius behind the end of the outline.
    assert pointer.x_mm == pytest.approx(MIDDLE[0], abs=2.0)
    assert pointer.y_mm == pytest.approx(MIDDLE[1] + 7.0, abs=2.0)


def test_a_late_tracker_does_not_make_the_tip_late(table: DrawnTable) -> None:
    state = start(table.profile, SensingSettings())
    path = [(MIDDLE[0] + 6.0 * n, MIDDLE[1]) for n in range(20)]
    for n, at_mm in enumerate(path):
        late = max(n - 2, 0)
        shown = table.frame(at_mm, height_mm=20.0, time_us=n * FRAME_US)
        frame, state = step(state, shown, table.hands(path[late], late * FRAME_US))
        if n > 2:
            assert table.off_mm(frame.pointers[0], at_mm, 20.0)[0] == pytest.approx(0.0, abs=2.0)


@pytest.mark.parametrize("off_mm", [(6.0, 0.0), (-6.0, 3.0), (0.0, 8.0), (4.0, -8.0)])
def test_landmarks_that_are_off_are_put_on_the_silhouette(
    table: DrawnTable, off_mm: tuple[float, float]
) -> None:
    state = start(table.profile, SensingSettings())
    frame, _ = step(state, table.frame(height_mm=20.0), table.hands(off_mm=off_mm))
    assert table.off_mm(frame.pointers[0], MIDDLE, 20.0) == pytest.approx((0.0, 0.0), abs=2.0)


@pytest.mark.parametrize("height_mm", [20.0, 40.0, 80.0])
def test_above_the_halo_height_is_read_off_the_fingers_own_depth(
    table: DrawnTable, height_mm: float
) -> None:
    frame = once(table, height_mm=height_mm)
    assert frame.pointers[0].hover_mm == pytest.approx(height_mm, abs=1.0)
    assert frame.pointers[0].pressure == 0.0


@pytest.mark.parametrize(
    ("at_mm", "height_mm"),
    [(MIDDLE, 130.0), ((355.0, 100.0), 20.0), ((150.0, -67.0), 20.0)],
    ids=["too high", "right of the surface", "beyond the far edge"],
)
def test_out_of_reach_is_no_pointer(
    table: DrawnTable, at_mm: tuple[float, float], height_mm: float
) -> None:
    assert once(table, at_mm, height_mm).pointers == ()


def test_a_hand_that_leaves_releases_its_touch(table: DrawnTable) -> None:
    frames, state = sense(table, (9, 9, 12, 12))
    assert frames[-1].pointers[0].state is Touch.TOUCH
    kinds_seen: list[str] = []
    for n in range(4, 14):
        gone = table.frame((MIDDLE[0], 2000.0), time_us=n * FRAME_US)
        frame, state = step(state, gone, Tracked(n * FRAME_US, ()))
        kinds_seen += [event.kind for event in frame.events]
    assert kinds_seen == ["up"]
    assert frame.pointers == ()


def test_a_touch_that_the_depth_shows_outlives_a_tracker_that_lost_the_hand(
    table: DrawnTable,
) -> None:
    frames, state = sense(table, (9, 9, 12, 12))
    for n in range(4, 64):
        at_mm = (MIDDLE[0] + 2.0 * (n - 4), MIDDLE[1])
        shown = table.frame(at_mm, dent_mm=12, time_us=n * FRAME_US)
        frame, state = step(state, shown, Tracked(n * FRAME_US, ()))
        assert [pointer.state for pointer in frame.pointers] == [Touch.TOUCH]
        assert table.off_mm(frame.pointers[0], at_mm)[0] == pytest.approx(0.0, abs=2.0)
    assert frame.pointers[0].id == frames[0].pointers[0].id


def test_a_frame_that_cannot_be_sensed_releases_all(table: DrawnTable) -> None:
    _, state = sense(table, (9, 9, 12, 12))
    frame, state = clear(state, 4 * FRAME_US)
    assert frame.pointers == ()
    assert [event.kind for event in frame.events] == ["up"]
    assert clear(state, 5 * FRAME_US)[0].events == ()


def test_an_id_is_never_given_twice(table: DrawnTable) -> None:
    frames, state = sense(table, (9, 9))
    first = frames[-1].pointers[0]
    _, state = clear(state, 2 * FRAME_US)
    time_us = 3 * FRAME_US
    again = step(state, table.frame(time_us=time_us), table.hands(time_us=time_us))[0].pointers[0]
    assert again.id > first.id
    assert again.slot == first.slot == 0


def test_without_a_profile_there_are_no_pointers(table: DrawnTable) -> None:
    frame, _ = step(start(None, SensingSettings()), table.frame(), table.hands())
    assert frame.pointers == ()
    assert frame.surface == "table"


def test_unmeasured_depth_is_neither_hand_nor_halo(table: DrawnTable) -> None:
    seen = table.frame()
    blind = Frame(0, np.zeros_like(seen.depth), seen.ir)
    frame, _ = step(start(table.profile, SensingSettings()), blind, table.hands())
    assert all(pointer.diagnostics.halo == 0.0 for pointer in frame.pointers)
    assert all(pointer.confidence < 0.5 for pointer in frame.pointers)


def test_the_same_frames_give_the_same_result(table: DrawnTable) -> None:
    dents = (0, 9, 10, 12, 16, 12, 9, 0)
    first, _ = sense(table, dents, late=1)
    again, _ = sense(table, dents, late=1)
    assert repr(first) == repr(again)  # nan equals nothing


def test_a_new_profile_releases_a_touch_with_its_up(table: DrawnTable) -> None:
    state = start(table.profile, SensingSettings())
    kinds: list[str] = []
    for n, dent_mm in enumerate([9, 9, 12, 12, 12, 12, 12]):
        if n == 4:
            state = adopt(state, replace(table.profile, revision=2))
        time_us = n * FRAME_US
        shown = table.frame(dent_mm=dent_mm, time_us=time_us)
        frame, state = step(state, shown, table.hands(time_us=time_us))
        kinds += [event.kind for event in frame.events]
    assert kinds == ["down", "up"]
