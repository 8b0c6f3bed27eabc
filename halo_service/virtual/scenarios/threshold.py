"""`threshold`: one key is tapped many times; the finger rises only a little between taps.

The smallest rise after which the next tap is still reported is what the paper calls the touch
point threshold (5.3.4). Each re-tap is a step `retap` of the script, with its `lift_mm`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.virtual.motion import Segment, Timeline, bump
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import comfortable, solo

LIFTS_MM = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
"""Around the paper's 4.97 mm and the 2 mm that is aimed for."""
ROUNDS = 10
"""Each lift so often, in random order: twelve people give 120 re-taps a lift."""
UP_S, ABOVE_S, DOWN_S = 0.09, 0.05, 0.07
"""Chosen: 0.2 s in the air, as fast as people tap on the spot (about 3 taps a second with a touch
of 0.1 s), and six frames to see it in."""
HOLD_S = (0.08, 0.15)
"""Duration of a tap."""
AWAY_MM = 20.0
"""Between two rounds the finger rises this far and moves to another spot."""


def threshold(room: Room, rng: np.random.Generator) -> Scenario:
    """Rounds of one tap and a re-tap for each lift, in random order; ends by itself."""
    return solo(room, rng, _rounds)


def _rounds(p: Timeline) -> Iterator[Segment]:
    yield from p.hold(2.5)
    yield from p.reach(1.2, x_mm=150.0, y_mm=100.0, height_mm=AWAY_MM)
    for _ in range(ROUNDS):
        x, y = p.rng.normal((150.0, 100.0), 25.0)
        yield from p.reach(0.5, x_mm=x, y_mm=y, height_mm=AWAY_MM, **comfortable(p))
        yield from p.strike(0.1)
        yield from _pressed(p)
        for lift_mm in p.rng.permutation(np.array(LIFTS_MM)):
            yield from p.step("retap", _retap(p, float(lift_mm)), lift_mm=float(lift_mm))
        yield from p.reach(0.3, height_mm=AWAY_MM)


def _retap(p: Timeline, lift_mm: float) -> Iterator[Segment]:
    yield from p.reach(UP_S, height_mm=lift_mm)
    yield from p.hold(ABOVE_S)
    yield from p.strike(DOWN_S)
    yield from _pressed(p)


def _pressed(p: Timeline) -> Iterator[Segment]:
    force_g = float(np.clip(p.rng.lognormal(np.log(55.0), 0.35), 15.0, 250.0))
    yield from p.press(p.rng.uniform(*HOLD_S), bump(force_g))
