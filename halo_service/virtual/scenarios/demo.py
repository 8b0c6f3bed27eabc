"""`demo`: hovers, taps, presses and strokes, without end, all within the first five seconds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.virtual.motion import Segment, Timeline, plateau
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import solo, somewhere
from halo_service.virtual.skeleton import FingerPose


def demo(room: Room, rng: np.random.Generator) -> Scenario:
    """One index finger over the table."""
    return solo(room, rng, _script, start=FingerPose(150.0, 110.0, 30.0, 0.0, 45.0, 0.0))


def _script(p: Timeline) -> Iterator[Segment]:
    while True:
        yield from p.reach(0.6, **somewhere(p), height_mm=p.rng.uniform(8.0, 14.0))
        yield from p.reach(0.5, height_mm=p.rng.uniform(4.0, 7.0))
        for _ in range(int(p.rng.integers(2, 4))):
            yield from p.tap(p.rng.uniform(0.1, 0.5), p.rng.uniform(25, 80), lift_mm=14.0)
            yield from p.hold(p.rng.uniform(0.15, 0.35))
        yield from p.strike(0.12)
        yield from p.press(p.rng.uniform(0.8, 1.2), plateau(p.rng.uniform(120, 330)))
        yield from p.reach(0.2, height_mm=15.0)
        yield from p.reach(0.6, lift_mm=10.0, **somewhere(p))
        yield from stroke(p)
        yield from p.reach(0.5, height_mm=p.rng.uniform(20.0, 45.0))


def stroke(p: Timeline) -> Iterator[Segment]:
    """A curved line of some centimetres towards the middle, with changing pressure."""
    x, y = p.pose.x_mm, p.pose.y_mm
    across = (150.0 - x) / 150.0 * 60.0 + p.rng.uniform(-40, 40)
    along = (100.0 - y) / 100.0 * 40.0 + p.rng.uniform(-20, 20)
    bend = p.rng.uniform(-18, 18)

    def slide(s: float) -> dict[str, float]:
        eased = s * s * (3.0 - 2.0 * s)
        curve = bend * float(np.sin(np.pi * eased))
        return {"x_mm": x + across * eased, "y_mm": y + along * eased + curve}

    yield from p.strike(0.14)
    yield from p.press(p.rng.uniform(0.9, 1.6), plateau(p.rng.uniform(60, 220)), slide)
    yield from p.reach(0.18, height_mm=15.0)
