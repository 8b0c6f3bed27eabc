"""`typing`: phrases on a keyboard of 16 mm keys, with both index fingers, without end.

Speed, rhythm and scatter are of people who type with two fingers on glass. The paper's
participants reached 26 words a minute when they balanced speed and accuracy (5.3): 0.45 s a key.
`typing-accurate` and `typing-fast` are the tasks on both sides of it (5.2.3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from halo_service.values import Side
from halo_service.virtual.motion import SHORTEST_S, Segment, Timeline, bump
from halo_service.virtual.room import WIDTH_MM, Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import at_near_edge, comfortable, pointer
from halo_type.layout import SPACE, Key, keyboard, load_layout
from halo_type.phrases import PHRASES

TOP_MM = 70.0
"""Where the keyboard begins below the surface's far edge, chosen."""
SPREAD = 0.25
"""Sigma of the logarithm of the time from key to key."""
LONGEST_S = 1.2
"""The longest pause within a phrase."""
LEAVE_S = 0.07
"""A finger rises from its key for this long."""
BEGIN_S, PAUSE_S = 4.5, 2.0
"""Before the first key, and between phrases."""


@dataclass(frozen=True, slots=True)
class Style:
    """How a user types."""

    key_s: float
    """Median time from key to key."""
    least_s: float
    """No two keys follow each other in less."""
    hold_s: float
    """Median time that a key is held; on glass about 0.08 to 0.12 s."""
    aim_mm: float
    """Scatter around a key's middle, one sigma each way: on touch keyboards 1.5 to 2.5 mm (Azenkot
    and Zhai 2012, Bi et al. 2013)."""
    lift_mm: tuple[float, float]
    """How high a finger rises on its way to a key."""

    @property
    def longest_hold_s(self) -> float:
        """No key is held longer: the same finger may have to strike the next one."""
        return min(0.15, self.least_s - LEAVE_S - SHORTEST_S - 0.005)


BALANCED = Style(0.45, 0.28, 0.1, 1.9, (8.0, 16.0))
"""The paper's T2."""
ACCURATE = Style(0.62, 0.35, 0.11, 1.5, (8.0, 16.0))
"""T1, accuracy first. Chosen: a third slower, and as close as people aim."""
FAST = Style(0.34, 0.24, 0.08, 2.4, (6.0, 12.0))
"""T3, speed first. Chosen: a quarter faster, as far off as people aim, lifting less."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """One key to hit."""

    when_s: float
    side: Side
    key: Key


def keys() -> dict[str, Key]:
    """The keyboard's place on the surface."""
    return keyboard((WIDTH_MM - load_layout("qwerty").width_mm) / 2.0, TOP_MM)


def plan(seed: int, style: Style = BALANCED) -> Iterator[Stroke]:
    """Which key each hand hits, and when, without end; both hands read the same plan."""
    rng = np.random.default_rng([seed, 4])
    layout, when_s = keys(), BEGIN_S
    while True:
        for number in rng.permutation(len(PHRASES)):
            side = Side.RIGHT
            for character in PHRASES[number]:
                key = layout[character]
                middle = key.middle[0]
                if character != SPACE:
                    side = Side.LEFT if middle < WIDTH_MM / 2.0 else Side.RIGHT
                yield Stroke(when_s, side, key)
                when_s += float(
                    np.clip(rng.lognormal(np.log(style.key_s), SPREAD), style.least_s, 1.2)
                )
            when_s += PAUSE_S


def typing(room: Room, rng: np.random.Generator) -> Scenario:
    """Speed and accuracy in balance."""
    return _typed(room, rng, BALANCED)


def accurate(room: Room, rng: np.random.Generator) -> Scenario:
    """Accuracy first."""
    return _typed(room, rng, ACCURATE)


def fast(room: Room, rng: np.random.Generator) -> Scenario:
    """Speed first."""
    return _typed(room, rng, FAST)


def _typed(room: Room, rng: np.random.Generator, style: Style) -> Scenario:
    """The left hand types the left half; the space bar goes to the hand that typed last."""
    room, motions = at_near_edge(room), []
    for side in (Side.LEFT, Side.RIGHT):
        motions.append(pointer(room, rng, lambda p: _strokes(p, room.seed, style), side)[1])
    return Scenario(room, motions)


def _strokes(p: Timeline, seed: int, style: Style) -> Iterator[Segment]:
    mine = (stroke for stroke in plan(seed, style) if stroke.side is p.side)
    home = WIDTH_MM / 2.0 + (45.0 if p.side is Side.RIGHT else -45.0)
    yield from p.hold(2.5)
    yield from p.reach(1.2, x_mm=home, y_mm=TOP_MM + 24.0, height_mm=14.0, **comfortable(p))
    for stroke in mine:
        aim = stroke.key.middle
        if stroke.key.character == SPACE:
            aim = float(np.clip(p.pose.x_mm, aim[0] - 25.0, aim[0] + 25.0)), aim[1]
        x, y = p.rng.normal(aim, style.aim_mm)
        yield from p.tap_at(
            stroke.when_s,
            float(np.clip(p.rng.lognormal(np.log(style.hold_s), 0.25), 0.05, style.longest_hold_s)),
            bump(float(np.clip(p.rng.lognormal(np.log(55.0), 0.35), 15.0, 250.0))),
            lift_mm=p.rng.uniform(*style.lift_mm),
            target_mm=aim,
            key=stroke.key.character,
            to={"x_mm": x, "y_mm": y},
        )
        yield from p.reach(LEAVE_S, height_mm=p.rng.uniform(7.0, 12.0))
