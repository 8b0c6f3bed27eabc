"""What hands do and trackers get wrong: the shortest taps, slides, lost frames and lost hands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from halo_service.profile import Profile
from halo_service.sensing import SensingSettings, State, start, step
from halo_service.values import Frame, Pointer, Side, Touch, TouchFrame, Tracked
from tests.drawn import FRAME_US, PER_DENT_MM

Draw = Callable[..., Frame]
See = Callable[..., Tracked]
Tip = tuple[float, float]
MIDDLE: Tip = (320.0, 288.0)
HOVERS, LIFTED, TOUCHES = 9, 10, 12
"""Dents, mm; the subtle state, 1 mm above the surface, is `LIFTED`."""


@pytest.fixture
def dented(profile: Profile) -> Profile:
    """The four states as dents of 9, 10, 12 and 16 mm, which can be drawn."""
    assert profile.touch is not None
    depths = {"hover": HOVERS, "subtle": LIFTED, "touch": TOUCHES, "pressure": 16}
    states = {
        name: replace(getattr(profile.touch, name), signal=depth * PER_DENT_MM)
        for name, depth in depths.items()
    }
    return replace(profile, touch=replace(profile.touch, **states))


@pytest.fixture
def play(dented: Profile, draw: Draw) -> Callable[..., tuple[list[TouchFrame], State]]:
    """Play (dent in mm, tip in px, what the tracker says) from a state on, frame by frame."""

    def played(
        scenes: Sequence[tuple[float, Tip, Tracked | None]],
        state: State | None = None,
        first: int = 0,
        dropped: frozenset[int] = frozenset(),
        every_us: int = FRAME_US,
    ) -> tuple[list[TouchFrame], State]:
        state = state or start(dented, SensingSettings())
        told = []
        for n, (dent, tip, seen) in enumerate(scenes, first):
            if n not in dropped:
                frame = draw(tip, signal=dent * PER_DENT_MM, time_us=n * every_us)
                result, state = step(state, frame, seen)
                told.append(result)
        return told, state

    return played


Play = Callable[..., tuple[list[TouchFrame], State]]


def kinds(told: Sequence[TouchFrame]) -> list[str]:
    return [event.kind for frame in told for event in frame.events]


def ids(told: Sequence[TouchFrame]) -> set[int]:
    return {pointer.id for frame in told for pointer in frame.pointers}


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
    play: Play, see: See, dents: Sequence[int], taps: int
) -> None:
    told, _ = play([(dent, MIDDLE, see(time_us=n * FRAME_US)) for n, dent in enumerate(dents)])
    assert kinds(told) == ["down", "up"] * taps


@pytest.mark.parametrize("px_a_frame", [3.0, 8.0, 15.0])
@pytest.mark.parametrize("late", [1, 3])
def test_a_stroke_is_one_touch_however_fast(
    play: Play, see: See, px_a_frame: float, late: int
) -> None:
    xs = [230.0] * 6 + [230.0 + px_a_frame * n for n in range(12)]
    scenes = [
        (
            HOVERS if n < 3 else TOUCHES,
            (x, 288.0),
            see((xs[max(n - late, 0)], 288.0), max(n - late, 0) * FRAME_US),
        )
        for n, x in enumerate(xs)
    ]
    told, _ = play(scenes)
    assert kinds(told) == ["down"]
    assert told[-1].pointers[0].diagnostics.tip_px[0] == pytest.approx(xs[-1], abs=2.0)


@pytest.mark.parametrize("beside_px", [20.0, 26.0])
@pytest.mark.parametrize(
    ("high_mm", "within"), [(30.0, 2), (5.0, 5)], ids=["that is higher", "as low"]
)
def test_a_finger_drawn_to_its_neighbour_goes_back_where_the_tracker_sees_it(
    dented: Profile, draw: Draw, see: See, beside_px: float, high_mm: float, within: int
) -> None:
    beside = (MIDDLE[0] + beside_px, MIDDLE[1])
    state, xs = start(dented, SensingSettings()), []
    for n in range(10):
        time_us = n * FRAME_US
        own, other = draw(MIDDLE, 0.0, 5.0, time_us), draw(beside, 0.0, high_mm, time_us)
        both = replace(own, depth=np.minimum(own.depth, other.depth))
        seen, state = step(state, both, see(beside if n < 3 else MIDDLE, time_us))
        xs.append(seen.pointers[0].diagnostics.tip_px[0])
    assert xs[2] == pytest.approx(beside[0], abs=3.0)
    assert xs[2 + within :] == pytest.approx([MIDDLE[0]] * (8 - within), abs=3.0)


@pytest.mark.parametrize("share", [0.005, 0.03])
def test_dropped_frames_cost_no_tap(play: Play, see: See, share: float) -> None:
    dents = (9, 9, 9, 12, 12, 12) * 30 + (9, 9, 9)
    lost = np.flatnonzero(np.random.default_rng(7).random(len(dents)) < share)
    assert lost.size
    scenes = [(dent, MIDDLE, see(time_us=n * FRAME_US)) for n, dent in enumerate(dents)]
    told, _ = play(scenes, dropped=frozenset(lost.tolist()))
    assert kinds(told) == ["down", "up"] * 30
    assert len(ids(told)) == 1


def test_a_hand_that_flips_its_side_keeps_id_and_touch(play: Play, see: See) -> None:
    scenes = []
    for n, dent in enumerate((9, 9, *(12,) * 12)):
        seen = see(time_us=n * FRAME_US)
        side = Side.LEFT if n % 3 == 2 else Side.RIGHT
        scenes.append((dent, MIDDLE, replace(seen, hands=(replace(seen.hands[0], side=side),))))
    told, _ = play(scenes)
    assert kinds(told) == ["down"]
    assert len(ids(told)) == 1
    assert told[-1].pointers[0].side is Side.RIGHT


@pytest.mark.parametrize("off", [(0.0, 0.0), (6.0, -4.0), (-9.0, 12.0)])
@pytest.mark.parametrize("side", [Side.LEFT, Side.RIGHT])
def test_a_hand_seen_twice_is_one_pointer(play: Play, see: See, off: Tip, side: Side) -> None:
    scenes = []
    for n, dent in enumerate((9, 9, 12, 12, 9, 9)):
        once, again = see(time_us=n * FRAME_US), see(off=off)
        double = replace(again.hands[0], side=side, confidence=0.7)
        scenes.append((dent, MIDDLE, replace(once, hands=(*once.hands, double))))
    told, _ = play(scenes)
    assert [len(frame.pointers) for frame in told] == [1] * 6
    assert kinds(told) == ["down", "up"]


SLOW_US = 100_000
"""Seconds pass in fewer frames."""


@pytest.mark.parametrize(
    ("dent", "step_px", "seconds", "stays"),
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
def test_what_lies_still_and_is_seen_by_no_tracker_is_a_thing(
    play: Play, see: See, dent: int, step_px: float, seconds: float, stays: bool
) -> None:
    start_x = 240.0
    begin = [
        (HOVERS if n < 3 else dent, (start_x, 288.0), see((start_x, 288.0), n * SLOW_US))
        for n in range(6)
    ]
    _, state = play(begin, every_us=SLOW_US)
    unseen = range(6, 6 + round(seconds * 10))
    scenes = [
        (dent, (start_x + step_px * (n - 5), 288.0), Tracked(n * SLOW_US, ())) for n in unseen
    ]
    told, _ = play(scenes, state, 6, every_us=SLOW_US)
    assert bool(told[-1].pointers) is stays
    assert kinds(told) == (["up"] if dent == TOUCHES and not stays else [])


def test_what_the_tracker_still_sees_may_rest_for_ever(play: Play, see: See) -> None:
    scenes = [(TOUCHES if n > 2 else HOVERS, MIDDLE, see(time_us=n * SLOW_US)) for n in range(130)]
    told, _ = play(scenes, every_us=SLOW_US)
    assert kinds(told) == ["down"]
    assert told[-1].pointers[0].state is Touch.TOUCH


def surely(
    play: Play, see: See, tip: Tip = MIDDLE, tracked_until: int = 9, off: float = 0
) -> float:
    """Return the confidence of a hovering finger after ten frames."""
    scenes = []
    for n in range(10):
        seen = see(tip, min(n, tracked_until) * FRAME_US, (off if n > 4 else 0.0, 0.0))
        scenes.append((HOVERS, tip, seen))
    told, _ = play(scenes)
    pointer: Pointer = told[-1].pointers[0]
    return pointer.confidence


@pytest.mark.parametrize(
    "doubtful",
    [{"tip": (320.0, 174.0)}, {"tracked_until": 3}, {"off": 45.0}],
    ids=["beyond the edge", "the tracker is silent", "the tracker sees it elsewhere"],
)
def test_a_finger_in_doubt_is_told_with_less_confidence(
    play: Play, see: See, doubtful: dict[str, object]
) -> None:
    assert surely(play, see, **doubtful) < 0.7 * surely(play, see)  # type: ignore[arg-type]


def test_a_velocity_is_that_of_now_while_a_finger_speeds_up(play: Play, see: See) -> None:
    """A line through the last four frames would tell four fifths of it."""
    xs = [200.0 + 2.0 * n * n for n in range(8)]
    told, _ = play([(0.0, (x, 288.0), see((x, 288.0), n * FRAME_US)) for n, x in enumerate(xs)])
    (pointer,) = told[-1].pointers
    assert pointer.vx_mm_s == pytest.approx(2.0 * 2 * 7 * 30.0, rel=0.1)
    assert pointer.vy_mm_s == pytest.approx(0.0, abs=30.0)
