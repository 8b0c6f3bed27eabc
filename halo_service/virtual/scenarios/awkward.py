"""`awkward`: touches where touch is hard to see: very flat and very steep fingers, and the edge.

A feint precedes each touch: the finger goes down as for a tap, stops short and rises again.
Reporting it as a touch is an error. The script names each pair `angle` with its `pitch_deg`, or
`edge` with its `beyond_mm`, negative inside the surface.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.virtual.motion import Segment, Timeline
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import comfortable, solo

PITCHES_DEG = (8.0, 15.0, 22.0, 65.0, 72.0, 80.0)
"""Around the 15 and 75 degrees between which the paper's halo can be relied on (4.3.4)."""
BEYOND_MM = (-12.0, -4.0, 4.0, 12.0)
"""Off the edge, chosen: on both sides of it, nearer than a fingertip is broad and farther."""
ROUNDS = 3
FEINT_MM = 4.0
"""How high a feint stops, chosen: twice what re-taps are judged by."""
LIFT_MM = 18.0
TOUCH_S = (0.2, 0.5)


def awkward(room: Room, rng: np.random.Generator) -> Scenario:
    """Each pitch, and each way off each edge, in random order; ends by itself."""
    return solo(room, rng, _rounds)


def _rounds(p: Timeline) -> Iterator[Segment]:
    yield from p.hold(2.5)
    yield from p.reach(1.2, x_mm=150.0, y_mm=100.0, height_mm=LIFT_MM)
    for _ in range(ROUNDS):
        for pitch_deg in p.rng.permutation(np.array(PITCHES_DEG)):
            x, y = p.rng.normal((150.0, 100.0), 30.0)
            to = comfortable(p) | {"x_mm": x, "y_mm": y, "pitch_deg": float(pitch_deg)}
            yield from p.step("angle", _feint_and_touch(p, to), pitch_deg=float(pitch_deg))
        for beyond_mm in p.rng.permutation(np.array(BEYOND_MM)):
            to = comfortable(p) | _off_an_edge(p, float(beyond_mm))
            yield from p.step("edge", _feint_and_touch(p, to), beyond_mm=float(beyond_mm))
    yield from p.reach(1.0, height_mm=60.0)


def _off_an_edge(p: Timeline, beyond_mm: float) -> dict[str, float]:
    """Give a place so far beyond one of the four edges."""
    x, y = p.rng.uniform(40.0, WIDTH_MM - 40.0), p.rng.uniform(40.0, HEIGHT_MM - 40.0)
    edge = int(p.rng.integers(4))
    if edge < 2:
        x = WIDTH_MM + beyond_mm if edge else -beyond_mm
    else:
        y = HEIGHT_MM + beyond_mm if edge == 3 else -beyond_mm
    return {"x_mm": x, "y_mm": y}


def _feint_and_touch(p: Timeline, to: dict[str, float]) -> Iterator[Segment]:
    yield from p.reach(0.6, lift_mm=8.0, height_mm=LIFT_MM, **to)
    yield from p.reach(0.15, height_mm=FEINT_MM)
    yield from p.hold(0.1)
    yield from p.reach(0.2, height_mm=LIFT_MM)
    yield from p.tap(p.rng.uniform(*TOUCH_S), p.rng.uniform(30.0, 150.0), LIFT_MM)
