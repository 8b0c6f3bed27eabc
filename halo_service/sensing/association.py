"""Assign detections to tracks.

The hand tracker sees a hand twice, confuses left and right, or one finger with another. A finger
must keep its id all the same, and must not get two.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from itertools import count, permutations
from typing import Any

import numpy as np

from halo_service.sensing.detections import Detection
from halo_service.sensing.finger_frame import Pixel, unit
from halo_service.sensing.kalman import Place, born, distance
from halo_service.sensing.label_pixels import FINGER_MM
from halo_service.sensing.registration import HeightMap, path_px
from halo_service.sensing.tracks import (
    BESIDE_MM,
    LANDMARK_MM,
    STRAYED_MM,
    Phase,
    Track,
    carried_on,
    detected,
)
from halo_service.values import Side

SLOTS = 10
"""Two hands' fingers."""
GATE, OTHER_SIDE_GATE, GATE_MM = 10.0, 3.75, 80.0
"""A detection farther than so many standard deviations from a track, or mm, is another finger: the
tracker's errors have long tails. Nearer for one of the other side, because sides flip in place."""
OTHER_SIDE_COST = 6.0
"""Twice the logarithm of how rarely a side flips: in one frame of twenty."""
IMPOSSIBLE = 1e6
"""Cost of a pair outside the gate."""
ON_FINGER_MM = 10.0
"""A new tip this near to a finger's line is that finger again (chosen: half a finger)."""
TURN_SHARE = 0.3
"""Of a new direction in the smoothed one (chosen: landmarks are some pixels off)."""
MOST_VOTES = 8
"""Left or right is decided by the detections of a quarter of a second."""
MOST_TRIED = 120
"""Assignments that are tried one by one: of four fingers to five detections."""
HAND_MM = 25.0
"""A place this near to a landmark is on the hand (chosen: half a palm)."""
REPLACED_US = 200_000
"""Tracker errors last single frames or a few in a row (chosen: six frames)."""


def associate(
    tracks: tuple[Track, ...],
    detections: tuple[Detection, ...],
    next_id: int,
    maps: Sequence[HeightMap] = (),
) -> tuple[Track, ...]:
    """Assign new detections to tracks, and start tentative tracks for the rest.

    `maps`: of the last frames, oldest first; they show how far a hand went since its detection.
    """
    paired = _pairs(tracks, detections)
    others = [each for j, each in enumerate(detections) if j not in paired.values()]
    kept = tuple(
        _detected(finger, detections[paired[i]], maps) if i in paired else finger
        for i, finger in enumerate(tracks)
        if not (_is_replaced(finger, detections, others, i in paired) or _is_double(finger, tracks))
    )
    new = [
        each
        for each in others
        if each.extended
        and not any(
            _is_on(finger, each.place_mm) and not _is_apart(each.place_mm, each, finger.detection)
            for finger in kept
        )
    ]
    taken = {finger.slot for finger in kept}
    slots = (slot for slot in range(SLOTS) if slot not in taken)
    started = zip(count(next_id), slots, new, strict=False)
    return kept + tuple(_started(*each, maps) for each in started)


def _pairs(tracks: Sequence[Track], detections: Sequence[Detection]) -> dict[int, int]:
    """Return the number of each track's detection: the likeliest assignment of all."""
    if not tracks or not detections:
        return {}
    costs = [[_cost(finger, each) for each in detections] for finger in tracks]
    fewer, more = sorted((len(tracks), len(detections)))
    few = math.perm(more, fewer) <= MOST_TRIED
    pairs = best_pairs(costs) if few else zip(*load_solver()(costs), strict=True)
    return {int(i): int(j) for i, j in pairs if costs[i][j] < IMPOSSIBLE}


def best_pairs(costs: Sequence[Sequence[float]]) -> list[tuple[int, int]]:
    """Return the assignment of rows to columns with the least sum, as many as there can be.

    It tries all: for a few fingers that is faster than SciPy's solver, and its import.
    """
    if len(costs) > len(costs[0]):
        return [(row, column) for column, row in best_pairs(list(zip(*costs, strict=True)))]
    tried = permutations(range(len(costs[0])), len(costs))
    return list(enumerate(min(tried, key=lambda columns: _sum(costs, columns))))


def _sum(costs: Sequence[Sequence[float]], columns: Iterable[int]) -> float:
    return sum(row[column] for row, column in zip(costs, columns, strict=True))


@cache
def load_solver() -> Any:
    """Import SciPy's solver, once: a quarter of a second, which few fingers do not need."""
    from scipy.optimize import linear_sum_assignment

    return linear_sum_assignment


def _cost(finger: Track, detection: Detection) -> float:
    """Return twice the negative logarithm of how likely a detection is a track's."""
    if finger.detection.finger is not detection.finger:
        return IMPOSSIBLE
    then = finger.at(detection.time_us)
    away = distance(then, detection.place_mm, LANDMARK_MM)
    same = detection.side in (finger.side, Side.UNKNOWN)
    if away > (GATE if same else OTHER_SIDE_GATE):
        return IMPOSSIBLE
    if math.dist(then.place_mm, detection.place_mm) > GATE_MM:
        return IMPOSSIBLE
    spread = 2.0 * math.log1p(then.place_mm2 / LANDMARK_MM**2)
    return away**2 + spread + (0.0 if same else OTHER_SIDE_COST)


def _started(
    id: int,  # noqa: A002 - the wire's name
    slot: int,
    detection: Detection,
    maps: Sequence[HeightMap],
) -> Track:
    direction = unit(detection.distal_px, detection.tip_px)
    state = born(detection.time_us, detection.place_mm, LANDMARK_MM)
    way_px = path_px(maps, detection.tip_px, detection.time_us)
    now_us = maps[-1].time_us if maps else detection.time_us
    state = carried_on(state, way_px, now_us, detection.on_surface)
    return Track(
        id,
        slot,
        detection,
        direction,
        detection.px_per_mm,
        _vote(detection.side),
        (state,),
        detection.time_us,
        went_px=way_px or (0.0, 0.0),
    )


def _detected(finger: Track, detection: Detection, maps: Sequence[HeightMap]) -> Track:
    """Return a track with a new detection; one that was seen before counts once."""
    if detection.time_us <= finger.detection.time_us:
        return finger
    votes = min(max(finger.votes + _vote(detection.side), -MOST_VOTES), MOST_VOTES)
    way_px = path_px(maps, detection.tip_px, detection.time_us)
    then_mm, now_mm = finger.at(detection.time_us).place_mm, finger.history[-1].place_mm
    off_mm = math.dist(then_mm, detection.place_mm)
    off_place = finger.off_place + 1 if off_mm > BESIDE_MM else 0
    seen = replace(
        finger,
        detection=detection,
        votes=votes,
        went_px=way_px or _way_px(then_mm, now_mm, detection.on_surface),
        history=detected(
            finger, detection.place_mm, detection.time_us, way_px, detection.on_surface
        ),
        off_mm=off_mm,
        off_place=off_place,
    )
    if seen.strayed:
        return seen
    (x, y), (new_x, new_y) = finger.direction, unit(detection.distal_px, detection.tip_px)
    turned = x + TURN_SHARE * (new_x - x), y + TURN_SHARE * (new_y - y)
    return replace(seen, direction=unit((0.0, 0.0), turned))


def _way_px(from_mm: Place, to_mm: Place, px_per_mm: float) -> Pixel:
    (x, y), (to_x, to_y) = from_mm, to_mm
    return (to_x - x) * px_per_mm, (to_y - y) * px_per_mm


def _vote(side: Side) -> int:
    return (side is Side.RIGHT) - (side is Side.LEFT)


def _is_replaced(
    finger: Track, detections: Sequence[Detection], new: Sequence[Detection], detected: bool
) -> bool:
    """Return whether this finger was detected elsewhere for long: a hand has only one of it.

    By a `new` detection of its side, or by one of the hand that it is on. A finger of the opposite
    side is only next to that hand: people type so.
    """
    return (
        not detected
        and not finger.debounce.contact.touching
        and any(
            other.finger is finger.detection.finger
            and other.time_us - finger.detection.time_us > REPLACED_US
            and (
                (other in new and other.side is finger.side)
                or (_is_on_hand(finger, other) and not _are_opposite(finger, other))
            )
            for other in detections
        )
    )


def _are_opposite(finger: Track, other: Detection) -> bool:
    return {finger.side, other.side} == {Side.LEFT, Side.RIGHT}


def _is_on_hand(finger: Track, other: Detection) -> bool:
    place_px = np.array(finger.history[-1].place_mm) * other.on_surface
    away_px = np.linalg.norm(other.hand_px - place_px, axis=1)
    return bool(away_px.min() < HAND_MM * other.on_surface)


def _is_double(finger: Track, tracks: Sequence[Track]) -> bool:
    """Return whether a hovering finger is on another one that is confirmed better."""
    if finger.debounce.contact.touching or finger.phase is Phase.TENTATIVE:
        return False
    mine = (-finger.strayed, finger.detection.time_us, -finger.id)
    return any(
        (-other.strayed, other.detection.time_us, -other.id) > mine
        and _is_on(other, finger.history[-1].place_mm)
        and not _is_apart(finger.history[-1].place_mm, finger.detection, other.detection)
        for other in tracks
        if other is not finger and other.phase is not Phase.TENTATIVE
    )


def _is_apart(place_mm: Place, own: Detection, other: Detection) -> bool:
    """Return whether one look shows two fingers: `own`, which is at a place, and another one.

    A thumb may be next to an index finger, or to the other hand's thumb.
    """
    is_own = math.dist(place_mm, own.place_mm) < STRAYED_MM
    apart_mm = math.dist(own.place_mm, other.place_mm)
    return is_own and own.time_us == other.time_us and apart_mm > BESIDE_MM


def _is_on(finger: Track, place_mm: Place) -> bool:
    """Return whether a tip is on a finger that has a track."""
    (x, y), (ux, uy) = finger.history[-1].place_mm, finger.direction
    dx, dy = x - place_mm[0], y - place_mm[1]
    back = min(max(dx * ux + dy * uy, 0.0), FINGER_MM)
    return math.dist((dx, dy), (back * ux, back * uy)) < ON_FINGER_MM
