"""`pointing`, `hover`, `pressure`: the tasks of the paper's study (5.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from halo_service.virtual.motion import Segment, Timeline, bump
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import comfortable, solo

GRID, CELL_MM = 4, 50.0
"""Sixteen targets: the centres of 5 cm cells in 20x20 cm."""
REGULAR_S, SWIFT_S = (0.3, 0.6), (0.1, 0.3)
"""Duration of a touch."""
PAUSE_S = 1.0
"""From one touch to the next."""
AIM_MM = 2.0
"""How far off people touch, one sigma each way; touches on screens show 1.5 to 3 mm (Bi et al.
2013), chosen within."""
HEIGHTS_MM = (5.0, 7.0, 10.0, 12.0, 15.0)
FORCES_G = tuple(385.0 * level for level in (0.1, 0.25, 0.5, 0.75, 1.0))
ROUNDS = 2
HOLD_S = 2.0


def targets() -> list[tuple[float, float]]:
    """The sixteen, row by row, mm."""
    offsets = [(k - (GRID - 1) / 2.0) * CELL_MM for k in range(GRID)]
    return [(WIDTH_MM / 2.0 + x, HEIGHT_MM / 2.0 + y) for y in offsets for x in offsets]


def pointing(room: Room, rng: np.random.Generator) -> Scenario:
    """Sets of sixteen touches in random order, regular and swift in turn, without end."""
    return solo(room, rng, _sets)


def _sets(p: Timeline) -> Iterator[Segment]:
    yield from p.hold(2.5)
    yield from p.reach(1.0, x_mm=150.0, y_mm=110.0, height_mm=22.0)
    while True:
        for name, (low, high) in (("regular", REGULAR_S), ("swift", SWIFT_S)):
            yield from p.step(name, _set(p, low, high))


def _set(p: Timeline, low_s: float, high_s: float) -> Iterator[Segment]:
    order = p.rng.permutation(GRID * GRID)
    for target in (targets()[k] for k in order):
        x, y = p.rng.normal(target, AIM_MM)
        yield from p.tap_at(
            p.now_s + p.rng.normal(PAUSE_S, 0.08),
            p.rng.uniform(low_s, high_s),
            bump(float(np.clip(p.rng.lognormal(np.log(60.0), 0.5), 15.0, 300.0))),
            lift_mm=p.rng.uniform(12.0, 25.0),
            target_mm=target,
            to={"x_mm": x, "y_mm": y, **comfortable(p)},
        )


def hover(room: Room, rng: np.random.Generator) -> Scenario:
    """The five heights, held twice each in random order; ends by itself."""
    return solo(room, rng, lambda p: _levels(p, HEIGHTS_MM, _hold_height))


def pressure(room: Room, rng: np.random.Generator) -> Scenario:
    """The five forces, held twice each in random order; ends by itself."""
    return solo(room, rng, lambda p: _levels(p, FORCES_G, _hold_force))


def _levels(
    p: Timeline,
    levels: tuple[float, ...],
    held: Callable[[Timeline, float], Iterator[Segment]],
) -> Iterator[Segment]:
    yield from p.hold(2.5)
    yield from p.reach(1.2, x_mm=150.0, y_mm=100.0, height_mm=30.0, pitch_deg=45.0)
    for _ in range(ROUNDS):
        for level in p.rng.permutation(np.array(levels)):
            # Not always on the same spot or at the same angle: people's hands were free (5.1).
            x, y = p.rng.normal((150.0, 100.0), 25.0)
            angles = comfortable(p)
            yield from p.reach(0.7, lift_mm=8.0, x_mm=x, y_mm=y, height_mm=20.0, **angles)
            yield from held(p, float(level))


def _hold_height(p: Timeline, height_mm: float) -> Iterator[Segment]:
    yield from p.reach(0.7, height_mm=height_mm)
    yield from p.hold(0.4)
    yield from p.step("hover", p.hold(HOLD_S), height_mm=height_mm)
    yield from p.reach(0.4, height_mm=25.0)


def _hold_force(p: Timeline, force_g: float) -> Iterator[Segment]:
    seconds = HOLD_S + 1.0
    phase = p.rng.uniform(0.0, 2.0 * np.pi)

    def force(s: float) -> float:
        waver = 1.0 + 0.03 * np.sin(2.0 * np.pi * 0.9 * s * seconds + phase)
        return force_g * min(1.0, s * seconds / 0.4) * float(waver)

    yield from p.strike(0.3)
    start_s = p.now_s + 0.7
    yield from p.press(seconds, force)
    p.note("pressure", start_s, start_s + HOLD_S, force_g=force_g)
    yield from p.reach(0.4, height_mm=25.0)
