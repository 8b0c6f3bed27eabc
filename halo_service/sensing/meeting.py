"""Which sighting is which finger.

The tracker sees a hand twice, mistakes a left one for a right one, or one finger for another: none
of that may cost a finger its id, or give one finger two.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import count

from halo_service.sensing.fingers import BESIDE_PX, Memory, was_at
from halo_service.sensing.sightings import Pixel, Sighting
from halo_service.sensing.straight import unit
from halo_service.sensing.territory import FINGER_PX
from halo_service.values import Side

SLOTS = 10
"""Two hands' fingers."""
SAME_FINGER_PX, OTHER_SIDE_PX = 80.0, 30.0
"""A sighting farther than this from a finger's tip is another finger (8 cm at 0.5 m); less where
the tracker calls it another hand's: hands flip in place."""
ON_FINGER_PX = 10.0
"""A stranger's tip this near to a finger's line is that finger again (chosen: half a finger)."""
STRAYED_PX = 30.0
"""The tracker's tips are 4 px off at the median and 28 at their worst: within that the depth's
word counts (measured on virtual hands at 0.5 m)."""
TURN_SHARE = 0.3
"""Of a new direction in the smoothed one (chosen: landmarks are some pixels off)."""
MOST_VOTES = 8
"""A quarter of a second of the tracker's opinions on left and right."""
REPLACED_US = 200_000
"""The tracker errs in single frames and in runs of a few (chosen: six frames)."""


def meet(live: tuple[Memory, ...], seen: tuple[Sighting, ...], next_id: int) -> tuple[Memory, ...]:
    """Give the live fingers their new sightings, nearest first, and take up the newcomers."""
    distances = sorted(
        (distance, i, j)
        for i, finger in enumerate(live)
        for j, sighting in enumerate(seen)
        if finger.sighting.finger is sighting.finger
        and (distance := _distance(finger, sighting)) < _reach(finger, sighting)
    )
    paired: dict[int, int] = {}
    for _, i, j in distances:
        if i not in paired and j not in paired.values():
            paired[i] = j
    others = [sighting for j, sighting in enumerate(seen) if j not in paired.values()]
    known = tuple(
        _sighted(finger, seen[paired[i]]) if i in paired else finger
        for i, finger in enumerate(live)
        if not (_is_replaced(finger, others, i in paired) or _is_double(finger, live))
    )
    strangers = [
        each for each in others if not any(_is_on(finger, each.tip_px) for finger in known)
    ]
    taken = {finger.slot for finger in known}
    slots = (slot for slot in range(SLOTS) if slot not in taken)
    newcomers = zip(count(next_id), slots, strangers, strict=False)
    return known + tuple(_born(*newcomer) for newcomer in newcomers)


def _born(id: int, slot: int, sighting: Sighting) -> Memory:  # noqa: A002 - the wire's name
    direction = unit(sighting.distal_px, sighting.tip_px)
    return Memory(id, slot, sighting, direction, _vote(sighting.side), sighting.time_us)


def _sighted(finger: Memory, sighting: Sighting) -> Memory:
    """Return a finger with the tracker's new word on it; a word said before counts once."""
    if sighting.time_us <= finger.sighting.time_us:
        return finger
    votes = min(max(finger.votes + _vote(sighting.side), -MOST_VOTES), MOST_VOTES)
    direction, astray = finger.direction, finger.astray + 1
    off_px = _distance(finger, sighting)
    doubted = finger.doubted + 1 if off_px > BESIDE_PX else 0
    if off_px <= STRAYED_PX:
        new = unit(sighting.distal_px, sighting.tip_px)
        dx, dy = TURN_SHARE * (new[0] - direction[0]), TURN_SHARE * (new[1] - direction[1])
        direction, astray = unit((0.0, 0.0), (direction[0] + dx, direction[1] + dy)), 0
    return replace(
        finger, sighting=sighting, votes=votes, direction=direction, doubted=doubted, astray=astray
    )


def _vote(side: Side) -> int:
    return (side is Side.RIGHT) - (side is Side.LEFT)


def _reach(finger: Memory, sighting: Sighting) -> float:
    return SAME_FINGER_PX if sighting.side in (finger.side, Side.UNKNOWN) else OTHER_SIDE_PX


def _is_replaced(finger: Memory, others: Sequence[Sighting], seen: bool) -> bool:
    """Say whether the tracker has long seen this very finger elsewhere: a hand has but one."""
    return (
        not seen
        and not finger.debounce.contact.touching
        and any(
            other.finger is finger.sighting.finger
            and other.side is finger.side
            and other.time_us - finger.sighting.time_us > REPLACED_US
            for other in others
        )
    )


def _is_double(finger: Memory, live: Sequence[Memory]) -> bool:
    """Say whether a hovering finger lies on another that the tracker confirms better."""
    if finger.debounce.contact.touching or not finger.path:
        return False
    mine = (-finger.astray, finger.sighting.time_us, -finger.id)
    return any(
        (-other.astray, other.sighting.time_us, -other.id) > mine
        and _is_on(other, finger.path[-1].tip_px)
        for other in live
        if other is not finger and other.path
    )


def _is_on(finger: Memory, place: Pixel) -> bool:
    """Say whether a tip lies on a finger that is there already."""
    tip = finger.path[-1].tip_px if finger.path else finger.sighting.tip_px
    ux, uy = finger.direction
    dx, dy = tip[0] - place[0], tip[1] - place[1]
    back = min(max(dx * ux + dy * uy, 0.0), FINGER_PX)
    return math.dist((dx, dy), (back * ux, back * uy)) < ON_FINGER_PX


def _distance(finger: Memory, sighting: Sighting) -> float:
    tip = was_at(finger.path, sighting.time_us).tip_px if finger.path else finger.sighting.tip_px
    return math.dist(tip, sighting.tip_px)
