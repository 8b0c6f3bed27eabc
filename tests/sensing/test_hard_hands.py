"""What hands do and trackers get wrong: the shortest taps, slides, lost frames and lost hands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from halo_service.sensing import SensingSettings, State, start, step
from halo_service.values import Pointer, Side, Touch, TouchFrame, Tracked
from tests.drawn import FRAME_US, MIDDLE, DrawnTable

Pair = tuple[float, float]
HOVERS, LIFTED, TOUCHES = 9, 10, 12
"""Dents, mm; the subtle state, 1 mm above the surface, is `LIFTED`."""
ROW_MM = MIDDLE[1]


@pytest.fixture
def run(table: DrawnTable) -> Callable[..., tuple[list[TouchFrame], State]]:
    """Sense (dent in mm, place in mm, tracked hands) from a state on, frame by frame."""

    def sensed(
        scenes: Sequence[tuple[float, Pair, Tracked | None]],
        state: State | None = None,
        first: int = 0,
        dropped: frozenset[int] = frozenset(),
        every_us: int = FRAME_US,
    ) -> tuple[list[TouchFrame], State]:
        state = state or start(table.profile, SensingSettings())
        frames = []
        for n, (dent_mm, at_mm, tracked) in enumerate(scenes, first):
            if n not in dropped:
                shown = table.frame(at_mm, dent_mm=dent_mm, time_us=n * every_us)
                frame, state = step(state, shown, tracked)
                frames.append(frame)
        return frames, state

    return sensed


Run = Callable[..., tuple[list[TouchFrame], State]]


def kinds(frames: Sequence[TouchFrame]) -> list[str]:
    return [event.kind for frame in frames for event in frame.events]


def ids(frames: Sequence[TouchFrame]) -> set[int]:
    return {pointer.id for frame in frames for pointer in frame.pointers}


@pytest.mark.parametrize(
    ("dents", "taps"),
    [
        ((9, 9, 12, 9, 9, 9), 1),
        ((9, 9, 12, 9, 9, 12, 9, 9), 2),
        ((9, 9, 12, 12, 10, 10, 12, 12, 9, 9), 2),
        ((9, 9, 12, 12, 9, 9, 12, 12, 12, 9, 9), 2),
        ((9, 10, 9, 10, 10, 9), 0),
    ],
    ids=["one frame", "one frame, twice", "lifted by 1 mm", "lifted by 10 mm", "only nearly"],
)
def test_the_shortest_taps_count_once_each(
    run: Run, table: DrawnTable, dents: Sequence[int], taps: int
) -> None:
    frames, _ = run(
        [(dent, MIDDLE, table.hands(time_us=n * FRAME_US)) for n, dent in enumerate(dents)]
    )
    assert kinds(frames) == ["down", "up"] * taps


@pytest.mark.parametrize("mm_a_frame", [3.0, 8.0, 15.0])
@pytest.mark.parametrize("late", [1, 3])
def test_a_stroke_is_one_touch_however_fast(
    run: Run, table: DrawnTable, mm_a_frame: float, late: int
) -> None:
    xs = [60.5] * 6 + [60.5 + mm_a_frame * n for n in range(12)]
    scenes = [
        (
            HOVERS if n < 3 else TOUCHES,
            (x, ROW_MM),
            table.hands((xs[max(n - late, 0)], ROW_MM), max(n - late, 0) * FRAME_US),
        )
        for n, x in enumerate(xs)
    ]
    frames, _ = run(scenes)
    assert kinds(frames) == ["down"]
    off_mm = table.off_mm(frames[-1].pointers[0], (xs[-1], ROW_MM))
    assert off_mm[0] == pytest.approx(0.0, abs=2.0)


@pytest.mark.parametrize("beside_mm", [20.0, 26.0])
@pytest.mark.parametrize(
    ("high_mm", "within"), [(30.0, 2), (5.0, 5)], ids=["that is higher", "as low"]
)
def test_a_track_on_the_neighbour_goes_back_to_the_detected_finger(
    table: DrawnTable, beside_mm: float, high_mm: float, within: int
) -> None:
    beside = (MIDDLE[0] + beside_mm, MIDDLE[1])
    state, pointers = start(table.profile, SensingSettings()), []
    for n in range(10):
        time_us = n * FRAME_US
        own = table.frame(MIDDLE, height_mm=5.0, time_us=time_us)
        other = table.frame(beside, height_mm=high_mm, time_us=time_us)
        both = replace(own, depth=np.minimum(own.depth, other.depth))
        frame, state = step(state, both, table.hands(beside if n < 3 else MIDDLE, time_us))
        pointers += frame.pointers
    assert table.off_mm(pointers[2], beside, high_mm)[0] == pytest.approx(0.0, abs=3.0)
    off_mm = [table.off_mm(each, MIDDLE, 5.0)[0] for each in pointers[2 + within :]]
    assert off_mm == pytest.approx([0.0] * (8 - within), abs=3.0)


@pytest.mark.parametrize("share", [0.005, 0.03])
def test_dropped_frames_cost_no_tap(run: Run, table: DrawnTable, share: float) -> None:
    dents = (9, 9, 9, 12, 12, 12) * 30 + (9, 9, 9)
    lost = np.flatnonzero(np.random.default_rng(7).random(len(dents)) < share)
    assert lost.size
    scenes = [(dent, MIDDLE, table.hands(time_us=n * FRAME_US)) for n, dent in enumerate(dents)]
    frames, _ = run(scenes, dropped=frozenset(lost.tolist()))
    assert kinds(frames) == ["down", "up"] * 30
    assert len(ids(frames)) == 1


def test_a_hand_that_flips_its_side_keeps_id_and_touch(run: Run, table: DrawnTable) -> None:
    scenes = []
    for n, dent in enumerate((9, 9, *(12,) * 12)):
        seen = table.hands(time_us=n * FRAME_US)
        side = Side.LEFT if n % 3 == 2 else Side.RIGHT
        scenes.append((dent, MIDDLE, replace(seen, hands=(replace(seen.hands[0], side=side),))))
    frames, _ = run(scenes)
    assert kinds(frames) == ["down"]
    assert len(ids(frames)) == 1
    assert frames[-1].pointers[0].side is Side.RIGHT


@pytest.mark.parametrize("off_mm", [(0.0, 0.0), (6.0, -4.0), (-9.0, 12.0)])
@pytest.mark.parametrize("side", [Side.LEFT, Side.RIGHT])
def test_a_hand_seen_twice_is_one_pointer(
    run: Run, table: DrawnTable, off_mm: Pair, side: Side
) -> None:
    scenes = []
    for n, dent in enumerate((9, 9, 12, 12, 9, 9)):
        first, again = table.hands(time_us=n * FRAME_US), table.hands(off_mm=off_mm)
        double = replace(again.hands[0], side=side, confidence=0.7)
        scenes.append((dent, MIDDLE, replace(first, hands=(*first.hands, double))))
    frames, _ = run(scenes)
    assert [len(frame.pointers) for frame in frames] == [1] * 6
    assert kinds(frames) == ["down", "up"]


SLOW_US = 100_000
"""Seconds pass in fewer frames."""


@pytest.mark.parametrize(
    ("dent", "step_mm", "seconds", "stays"),
    [
        (HOVERS, 0.0, 1.5, True),
        (HOVERS, 0.0, 2.5, False),
        (HOVERS, 2.0, 4.0, True),
        (TOUCHES, 0.0, 9.0, True),
        (TOUCHES, 0.0, 11.0, False),
        (TOUCHES, 1.0, 11.0, True),
    ],
    ids=["rests", "left behind", "moves", "holds", "left pressing", "slides"],
)
def test_what_is_still_and_not_detected_is_an_object(
    run: Run, table: DrawnTable, dent: int, step_mm: float, seconds: float, stays: bool
) -> None:
    start_x = 70.5
    begin = [
        (HOVERS if n < 3 else dent, (start_x, ROW_MM), table.hands((start_x, ROW_MM), n * SLOW_US))
        for n in range(6)
    ]
    _, state = run(begin, every_us=SLOW_US)
    unseen = range(6, 6 + round(seconds * 10))
    scenes = [
        (dent, (start_x + step_mm * (n - 5), ROW_MM), Tracked(n * SLOW_US, ())) for n in unseen
    ]
    frames, _ = run(scenes, state, 6, every_us=SLOW_US)
    assert bool(frames[-1].pointers) is stays
    assert kinds(frames) == (["up"] if dent == TOUCHES and not stays else [])


def test_a_detected_finger_may_rest_without_end(run: Run, table: DrawnTable) -> None:
    scenes = [
        (TOUCHES if n > 2 else HOVERS, MIDDLE, table.hands(time_us=n * SLOW_US)) for n in range(130)
    ]
    frames, _ = run(scenes, every_us=SLOW_US)
    assert kinds(frames) == ["down"]
    assert frames[-1].pointers[0].state is Touch.TOUCH


def confidence(
    run: Run, table: DrawnTable, at_mm: Pair = MIDDLE, tracked_until: int = 9, off: float = 0
) -> float:
    """Return the confidence of a hovering finger after ten frames."""
    scenes = []
    for n in range(10):
        seen = table.hands(at_mm, min(n, tracked_until) * FRAME_US, (off if n > 4 else 0.0, 0.0))
        scenes.append((HOVERS, at_mm, seen))
    frames, _ = run(scenes)
    pointer: Pointer = frames[-1].pointers[0]
    return pointer.confidence


@pytest.mark.parametrize(
    "uncertain",
    [{"at_mm": (150.5, -13.5)}, {"tracked_until": 3}, {"off": 45.0}],
    ids=["beyond the edge", "the tracker is silent", "the tracker sees it elsewhere"],
)
def test_an_uncertain_finger_has_a_lower_confidence(
    run: Run, table: DrawnTable, uncertain: dict[str, object]
) -> None:
    assert confidence(run, table, **uncertain) < 0.7 * confidence(run, table)  # type: ignore[arg-type]


def test_a_velocity_is_that_of_now_while_a_finger_speeds_up(run: Run, table: DrawnTable) -> None:
    """A line through the last four frames would give four fifths of it."""
    xs = [30.5 + 2.0 * n * n for n in range(8)]
    frames, _ = run(
        [(0.0, (x, ROW_MM), table.hands((x, ROW_MM), n * FRAME_US)) for n, x in enumerate(xs)]
    )
    (pointer,) = frames[-1].pointers
    assert pointer.vx_mm_s == pytest.approx(2.0 * 2 * 7 * 30.0, rel=0.1)
    assert pointer.vy_mm_s == pytest.approx(0.0, abs=30.0)
