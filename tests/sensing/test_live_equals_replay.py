"""What differs between live and replay changes no touch: late hands, lost frames, a slow camera."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from halo_service.sensing import SensingSettings, start, step
from halo_service.values import Frame, Hand, Side, TouchFrame, Tracked
from tests.drawn import FRAME_US, PLAIN

Pair = tuple[float, float]
STILL, DOWN, AWAY = 4, 3, 9
"""Frames over a place, in contact, and on the way to the next place."""
PLACES = (60.5, 110.5, 180.5, 240.5)
ROW_MM = 100.5


def path() -> list[tuple[float, float]]:
    """Return x in mm and the dent's depth in mm, a frame each: a tap at each of the places."""
    frames = [(PLACES[0], 9.0)] * 6  # until the latest hands are there
    for here, following in zip(PLACES, (*PLACES[1:], PLACES[-1]), strict=True):
        frames += [(here, 9.0)] * STILL + [(here, 12.0)] * DOWN + [(here, 9.0)] * STILL
        gone = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, AWAY, endpoint=False))
        frames += [(x, 9.0) for x in (here + (following - here) * gone[1:]).tolist()]
    return frames


def sense(late: int, shown: Iterable[int] | None = None) -> list[TouchFrame]:
    """Sense the path with hands so many frames old; `shown`: the frames that arrive."""
    frames, state, results = path(), start(PLAIN.profile, SensingSettings()), []
    arrived: list[Tracked] = []
    for n in range(len(frames)) if shown is None else shown:
        (x, dent_mm), time_us = frames[n], n * FRAME_US
        arrived.append(PLAIN.hands((x, ROW_MM), time_us))
        hands = arrived[-1 - late] if late < len(arrived) else None
        shot = PLAIN.frame((x, ROW_MM), dent_mm, time_us=time_us)
        result, state = step(state, shot, hands)
        results.append(result)
    return results


def downs(frames: Iterable[TouchFrame]) -> list[tuple[int, int, int]]:
    """Return id, frame and place of each touch."""
    return [
        (event.id, frame.time_us // FRAME_US, round(event.x_mm))
        for frame in frames
        for event in frame.events
        if event.kind == "down"
    ]


def test_the_path_has_a_touch_at_each_place() -> None:
    touched = downs(sense(0))
    assert [x for _, _, x in touched] == pytest.approx(PLACES, abs=1.0)
    assert len({id_ for id_, _, _ in touched}) == 1


@pytest.mark.parametrize("late", range(1, 7))
def test_late_hands_give_the_same_touches(late: int) -> None:
    assert downs(sense(late)) == downs(sense(0))


@pytest.mark.parametrize("late", [1, 3])
def test_a_second_at_15_frames_a_second_gives_the_same_touches(late: int) -> None:
    frames = range(len(path()))
    slow = [n for n in frames if not 5 <= n < 35 or n % 2]
    touched = downs(sense(late, slow))
    assert [x for _, _, x in touched] == [x for _, _, x in downs(sense(0))]
    assert len({id_ for id_, _, _ in touched}) == 1


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("late", [0, 1, 3])
def test_a_camera_of_15_frames_a_second_gives_the_same_touches(first: int, late: int) -> None:
    touched = downs(sense(late, range(first, len(path()), 2)))
    assert [x for _, _, x in touched] == [x for _, _, x in downs(sense(0))]
    assert len({id_ for id_, _, _ in touched}) == 1
    later = [a[1] - b[1] for a, b in zip(touched, downs(sense(0)), strict=True)]
    assert set(later) == {0, 1}, "at most a frame of 33 ms later"


@pytest.mark.parametrize("seed", range(4))
def test_dropped_frames_give_the_same_touches(seed: int) -> None:
    lost = np.random.default_rng(seed).random(len(path())) < 0.1
    touched = downs(sense(2, [n for n in range(len(path())) if not lost[n]]))
    assert [x for _, _, x in touched] == [x for _, _, x in downs(sense(0))]


def together(*fingers: tuple[Pair, float, float], time_us: int) -> Frame:
    """Draw several fingers at (place in mm, dent in mm, height in mm)."""
    shots = [PLAIN.frame(at, dent, height, time_us) for at, dent, height in fingers]
    surface = round(PLAIN.distance_mm)
    nearest = np.minimum.reduce([each.depth for each in shots])
    deepest = np.maximum.reduce([each.depth for each in shots])
    return replace(shots[0], depth=np.where(nearest < surface, nearest, deepest))


def hand(at_mm: Pair, side: Side) -> Hand:
    return replace(PLAIN.hands(at_mm).hands[0], side=side)


@pytest.mark.parametrize("late", [1, 3, 6])
def test_crossing_hands_keep_their_ids(late: int) -> None:
    """One passes ahead of the other, 30 mm farther out."""
    xs = np.linspace(60.5, 240.5, 40).tolist()
    state, owners = start(PLAIN.profile, SensingSettings()), []
    for n in range(len(xs)):
        near, far = (xs[n], 130.5), (xs[-1 - n], 60.5)
        then = max(n - late, 0)
        seen = (hand((xs[then], 130.5), Side.LEFT), hand((xs[-1 - then], 60.5), Side.RIGHT))
        shot = together((near, 0.0, 20.0), (far, 0.0, 60.0), time_us=n * FRAME_US)
        result, state = step(state, shot, Tracked(then * FRAME_US, seen))
        owners.append({p.id: p.side for p in result.pointers})
    assert owners[0] == owners[-1]
    assert len(owners[0]) == 2
    assert {id_ for each in owners for id_ in each} == set(owners[0])
