"""`drumming`: the dominant hand drums, the other hovers and bends the sound (paper, section 5's
drum: the closer the hovering hand, the deeper)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.values import Side
from halo_service.virtual.motion import Segment, Timeline, bump
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario, other
from halo_service.virtual.scenarios.common import at_near_edge, comfortable, pointer

TIMING_S = 0.012
"""How unevenly people drum, one sigma; published asynchronies of drummers are 10 to 20 ms."""
STROKES = ((0.0, 1.0), (0.5, 0.5), (1.0, 0.8), (1.5, 0.4), (2.0, 1.0), (2.5, 0.5), (3.0, 0.9))
"""A bar: beat and accent."""


def drumming(room: Room, rng: np.random.Generator) -> Scenario:
    """Never ends."""
    room = at_near_edge(room)
    tempo_s = 60.0 / rng.uniform(84.0, 116.0)
    sign = 1.0 if room.dominant is Side.RIGHT else -1.0
    hands = [
        pointer(room, rng, lambda p: _bars(p, tempo_s, sign)),
        pointer(room, rng, lambda p: _sway(p, sign), other(room.dominant)),
    ]
    return Scenario(room, [motion for _, motion in hands], hands[0][0].steps)


def _bars(p: Timeline, tempo_s: float, sign: float) -> Iterator[Segment]:
    """Two drums, 5 cm apart, on the hand's own side."""
    yield from p.hold(2.5)
    yield from p.reach(1.0, x_mm=150.0 + sign * 60.0, y_mm=100.0, height_mm=30.0)
    angles = comfortable(p)
    bar_s = p.now_s + 0.4
    while True:
        for beat, accent in STROKES:
            drum = sign * (55.0 if p.rng.random() < 0.6 else 105.0)
            target = 150.0 + drum, 95.0
            x, y = p.rng.normal(target, 3.0)
            loud = accent * p.rng.uniform(0.8, 1.2)
            yield from p.tap_at(
                max(bar_s + beat * tempo_s + p.rng.normal(0.0, TIMING_S), p.now_s + 0.1),
                p.rng.uniform(0.06, 0.12),
                bump(40.0 + 180.0 * loud),
                lift_mm=10.0 + 30.0 * loud,
                target_mm=target,
                to={"x_mm": x, "y_mm": y, **angles},
            )
        bar_s += 4.0 * tempo_s


def _sway(p: Timeline, sign: float) -> Iterator[Segment]:
    """Up and down, slowly, with rests."""
    yield from p.hold(2.7)
    yield from p.reach(1.0, x_mm=150.0 - sign * 75.0, y_mm=100.0, height_mm=40.0, **comfortable(p))
    while True:
        yield from p.reach(p.rng.uniform(0.5, 1.6), height_mm=p.rng.uniform(4.0, 75.0))
        yield from p.hold(p.rng.uniform(0.0, 0.8) + 0.01)
