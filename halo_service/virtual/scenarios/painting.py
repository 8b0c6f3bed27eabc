"""`painting`: strokes with changing pressure, without end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.virtual.motion import Segment, Timeline, smooth
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import solo, somewhere

SPEED_MM_S = (40.0, 160.0)
"""Of a drawing finger, chosen."""
EDGE_MM = 25.0


def painting(room: Room, rng: np.random.Generator) -> Scenario:
    """One index finger."""
    return solo(room, rng, _strokes)


def _strokes(p: Timeline) -> Iterator[Segment]:
    yield from p.hold(2.5)
    yield from p.reach(1.0, **somewhere(p), height_mm=20.0)
    while True:
        yield from p.strike(p.rng.uniform(0.1, 0.18))
        yield from _stroke(p)
        yield from p.reach(0.2, height_mm=p.rng.uniform(8.0, 20.0))
        yield from p.reach(p.rng.uniform(0.4, 0.8), lift_mm=8.0, **somewhere(p))


def _stroke(p: Timeline) -> Iterator[Segment]:
    """A smooth curve through three more points."""
    begin = np.array([p.pose.x_mm, p.pose.y_mm])
    low, high = np.full(2, EDGE_MM), np.array([WIDTH_MM, HEIGHT_MM]) - EDGE_MM
    corners = [np.clip(begin + p.rng.normal(0.0, 55.0, 2), low, high) for _ in range(3)]
    # The same place to begin and end a Bezier curve's handles: it leaves and arrives softly.
    a, b, c, d = begin, corners[0], corners[1], corners[2]
    length = sum(float(np.hypot(*(v - u))) for u, v in ((a, b), (b, c), (c, d)))
    seconds = max(0.5, 0.75 * length / p.rng.uniform(*SPEED_MM_S))
    levels = p.rng.uniform(30.0, 320.0, 4)

    def slide(s: float) -> dict[str, float]:
        t = smooth(s)
        u = 1.0 - t
        at = u**3 * a + 3.0 * u * u * t * b + 3.0 * u * t * t * c + t**3 * d
        return {"x_mm": float(at[0]), "y_mm": float(at[1])}

    def force(s: float) -> float:
        along = np.interp(s, (0.0, 0.3, 0.7, 1.0), levels)
        return float(along) * min(1.0, s * seconds / 0.15, (1.0 - s) * seconds / 0.12 + 0.05)

    yield from p.press(seconds, force, slide)
