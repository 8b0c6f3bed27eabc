"""Which track a node's new pointer belongs to, and which tracks are one finger.

Rule: pure. The assignment of all new pointers of a node is solved at once, with a gate.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np

from halo_service.canvas.blend import velocity
from halo_service.canvas.detections import Detection
from halo_service.canvas.tracks import Track

LAYOUT_MM = 2.5
"""Standard deviation of where two surfaces are relative to each other."""
CLOCK_S = 0.02
"""The same of two nodes' clocks, and of how late a node follows a finger."""
GATE, GATE_MM = 3.5, 50.0
"""Greatest distance of a pointer from its track, in standard deviations and in mm."""
VANISHED_MM = 6.0
"""Added deviation of a finger that no node sees at the moment."""
OTHER_FINGER, OTHER_SIDE = 5.0, 2.0
"""Twice the logarithm of how rarely two nodes name one finger, or its hand, differently."""
OTHER_FINGER_MM = 12.0
"""Greatest distance of one finger that two nodes name differently: neighbours are 15 mm apart."""
HOVER_MM, HOVER_MOST = 10.0, 4.0
"""Standard deviation of the difference of two nodes' heights, and the limit of its cost: a node
that has just found a finger may be wrong by any height."""
FOUND_MM, FOUND_COST = 250.0, 12.0
"""Greatest distance at which a finger that no node sees well is found again by its name, and the
cost: a hand at 2 m/s moves so far in four frames, and a finger within the gate costs less."""
IMPOSSIBLE = 1e6
NEW_US = 300_000
"""A finger that is found again has a second track for less time (chosen: nine frames). Two tracks
that last are the fingers of two people."""
APART_US = 200_000
"""Time after which a report outside of the gate is of another finger."""
ONE_GATE = 2.0
"""Greatest distance of two tracks that are one finger, in standard deviations."""


def assign(tracks: Sequence[Track], pointers: Sequence[Detection], time_us: int) -> dict[int, int]:
    """Return the number of each pointer's track, for those that belong to one."""
    if not tracks or not pointers:
        return {}
    costs = np.array([[_cost(track, each, time_us) for track in tracks] for each in pointers])
    pairs = zip(*load_solver()(costs), strict=True)
    return {int(i): int(j) for i, j in pairs if costs[i, j] < IMPOSSIBLE}


def is_apart(track: Track, seen: Detection) -> bool:
    """Whether one node's report is far from the merged place."""
    away_mm = math.dist(track.blend.estimate_mm(seen.time_us), seen.place_mm)
    return away_mm > GATE_MM or away_mm > 2.0 * GATE * _deviation(track, seen)


def doubles(tracks: Sequence[Track], time_us: int) -> Iterator[tuple[Track, Track]]:
    """Yield pairs of tracks that seem to be one finger, the older one first."""
    seen = sorted((each for each in tracks if each.members), key=lambda each: each.id)
    for older, younger in combinations(seen, 2):
        away_mm = _distance_mm(older, younger, time_us)
        new = time_us - min(younger.first_us.values(), default=0) < NEW_US
        again = new and away_mm < FOUND_MM and _finds_again(older, younger.blend.best())
        if again or (away_mm <= GATE_MM and _is_one(older, younger, away_mm, time_us)):
            yield older, younger


def _distance_mm(a: Track, b: Track, time_us: int) -> float:
    """Return the distance of two tracks, predicted or as reported: a finger may have stopped."""
    ab = a.blend, b.blend
    return min(math.dist(*(each.estimate_mm(at_us) for each in ab)) for at_us in (time_us, 0))


def _is_one(a: Track, b: Track, away_mm: float, time_us: int) -> bool:
    """Whether two tracks of different nodes are one finger by their distance."""
    two = any(a.is_reliable_on(each) and b.is_reliable_on(each) for each in a.nodes & b.nodes)
    if two or a.finger != b.finger:
        return False
    late_mm = CLOCK_S * math.hypot(*velocity(a.blend, time_us))
    both_mm = math.hypot(a.blend.deviation_mm, b.blend.deviation_mm, LAYOUT_MM, late_mm)
    return away_mm < ONE_GATE * both_mm


def _cost(track: Track, seen: Detection, time_us: int) -> float:
    """Return twice the negative logarithm of how likely a pointer is a track's."""
    on_surface = [each for each in track.members.values() if each.member[0] == seen.member[0]]
    if any(seen.is_weaker(each) for each in on_surface):
        return IMPOSSIBLE
    away_mm = math.dist(track.blend.estimate_mm(time_us), seen.place_mm)
    if away_mm < FOUND_MM and _finds_again(track, seen):
        return FOUND_COST + away_mm / FOUND_MM
    away = away_mm / _deviation(track, seen)
    if away > GATE or away_mm > GATE_MM:
        return IMPOSSIBLE
    best = track.blend.best().pointer
    if best.finger != seen.pointer.finger and away_mm > OTHER_FINGER_MM:
        return IMPOSSIBLE
    height = (best.hover_mm - seen.pointer.hover_mm) / HOVER_MM
    finger = OTHER_FINGER if best.finger != seen.pointer.finger else 0.0
    sides = {best.hand, seen.pointer.hand} - {0}
    cost = away**2 + min(height**2, HOVER_MOST) + finger + (OTHER_SIDE if len(sides) > 1 else 0.0)
    return cost if cost < 2.0 * GATE**2 else IMPOSSIBLE


def _finds_again(track: Track, seen: Detection) -> bool:
    """Whether a node sees a finger well that all others have lost: it has the same name."""
    if seen.weak or not seen.pointer.hand or not all(e.weak for e in track.members.values()):
        return False
    names = {each.name for each in track.members.values()}
    return seen.name in {*names, (track.side, track.finger)}


def _deviation(track: Track, seen: Detection) -> float:
    """Return the standard deviation of the distance of a pointer from its track, mm."""
    of_track = velocity(track.blend, seen.time_us)
    speed_mm_s = max(math.hypot(*seen.velocity_mm_s), math.hypot(*of_track))
    lost_mm = 0.0 if track.members else VANISHED_MM
    own_mm = min(track.blend.deviation_mm, seen.deviation_mm * 2.0)
    return math.hypot(own_mm, seen.deviation_mm, LAYOUT_MM, CLOCK_S * speed_mm_s, lost_mm)


@cache
def load_solver() -> Any:
    """Import SciPy's solver, once; programs that only read layouts do not wait for it."""
    from scipy.optimize import linear_sum_assignment

    return linear_sum_assignment
