"""Assign detections to tracks.

The hand tracker sees a hand twice, confuses left and right, or one finger with another. A finger
must keep its id all the same, and must not get two.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import count

from halo_service.sensing.detections import Detection
from halo_service.sensing.finger_frame import Pixel, unit
from halo_service.sensing.label_pixels import FINGER_MM
from halo_service.sensing.tracks import BESIDE_MM, Track, was_at
from halo_service.values import Side

SLOTS = 10
"""Two hands' fingers."""
SAME_FINGER_MM, OTHER_SIDE_MM = 80.0, 30.0
"""A detection farther than this from a track's tip is another finger (8 cm); less if it
has the other side, because sides flip in place."""
ON_FINGER_MM = 10.0
"""A new tip this near to a finger's line is that finger again (chosen: half a finger)."""
STRAYED_MM = 30.0
"""The tracker's tips are 4 mm off at the median and 28 at worst: within that the depth image
decides (measured on virtual hands at 0.5 m)."""
TURN_SHARE = 0.3
"""Of a new direction in the smoothed one (chosen: landmarks are some pixels off)."""
MOST_VOTES = 8
"""Left or right is decided by the detections of a quarter of a second."""
REPLACED_US = 200_000
"""Tracker errors last single frames or a few in a row (chosen: six frames)."""


def associate(
    tracks: tuple[Track, ...], detections: tuple[Detection, ...], next_id: int
) -> tuple[Track, ...]:
    """Assign new detections to tracks, nearest first, and start tracks for the rest."""
    distances = sorted(
        (distance, i, j)
        for i, finger in enumerate(tracks)
        for j, detection in enumerate(detections)
        if finger.detection.finger is detection.finger
        and (distance := _distance(finger, detection)) < _reach(finger, detection)
    )
    paired: dict[int, int] = {}
    for _, i, j in distances:
        if i not in paired and j not in paired.values():
            paired[i] = j
    others = [detection for j, detection in enumerate(detections) if j not in paired.values()]
    kept = tuple(
        _corrected_by(finger, detections[paired[i]]) if i in paired else finger
        for i, finger in enumerate(tracks)
        if not (_is_replaced(finger, others, i in paired) or _is_double(finger, tracks))
    )
    new = [
        each
        for each in others
        if each.extended and not any(_is_on(finger, each.tip_px) for finger in kept)
    ]
    taken = {finger.slot for finger in kept}
    slots = (slot for slot in range(SLOTS) if slot not in taken)
    started = zip(count(next_id), slots, new, strict=False)
    return kept + tuple(_started(*each) for each in started)


def _started(id: int, slot: int, detection: Detection) -> Track:  # noqa: A002 - the wire's name
    direction = unit(detection.distal_px, detection.tip_px)
    votes = _vote(detection.side)
    return Track(id, slot, detection, direction, detection.px_per_mm, votes, detection.time_us)


def _corrected_by(finger: Track, detection: Detection) -> Track:
    """Return a track with a new detection; one that was seen before counts once."""
    if detection.time_us <= finger.detection.time_us:
        return finger
    votes = min(max(finger.votes + _vote(detection.side), -MOST_VOTES), MOST_VOTES)
    direction, contradicted = finger.direction, finger.contradicted + 1
    off_mm = _distance(finger, detection)
    off_path = finger.off_path + 1 if off_mm > BESIDE_MM else 0
    if off_mm <= STRAYED_MM:
        new = unit(detection.distal_px, detection.tip_px)
        dx, dy = TURN_SHARE * (new[0] - direction[0]), TURN_SHARE * (new[1] - direction[1])
        direction, contradicted = unit((0.0, 0.0), (direction[0] + dx, direction[1] + dy)), 0
    return replace(
        finger,
        detection=detection,
        votes=votes,
        direction=direction,
        off_path=off_path,
        contradicted=contradicted,
    )


def _vote(side: Side) -> int:
    return (side is Side.RIGHT) - (side is Side.LEFT)


def _reach(finger: Track, detection: Detection) -> float:
    return SAME_FINGER_MM if detection.side in (finger.side, Side.UNKNOWN) else OTHER_SIDE_MM


def _is_replaced(finger: Track, others: Sequence[Detection], detected: bool) -> bool:
    """Return whether this finger was detected elsewhere for long: a hand has only one of it."""
    return (
        not detected
        and not finger.debounce.contact.touching
        and any(
            other.finger is finger.detection.finger
            and other.side is finger.side
            and other.time_us - finger.detection.time_us > REPLACED_US
            for other in others
        )
    )


def _is_double(finger: Track, tracks: Sequence[Track]) -> bool:
    """Return whether a hovering finger is on another one that is confirmed better."""
    if finger.debounce.contact.touching or not finger.path:
        return False
    mine = (-finger.contradicted, finger.detection.time_us, -finger.id)
    return any(
        (-other.contradicted, other.detection.time_us, -other.id) > mine
        and _is_on(other, finger.path[-1].tip_px)
        for other in tracks
        if other is not finger and other.path
    )


def _is_on(finger: Track, place: Pixel) -> bool:
    """Return whether a tip is on a finger that has a track."""
    tip = finger.path[-1].tip_px if finger.path else finger.detection.tip_px
    ux, uy = finger.direction
    size = finger.px_per_mm
    dx, dy = (tip[0] - place[0]) / size, (tip[1] - place[1]) / size
    back = min(max(dx * ux + dy * uy, 0.0), FINGER_MM)
    return math.dist((dx, dy), (back * ux, back * uy)) < ON_FINGER_MM


def _distance(finger: Track, detection: Detection) -> float:
    """Return how far a detection is from where the finger was at its time, mm."""
    tip = was_at(finger.path, detection.time_us).tip_px if finger.path else finger.detection.tip_px
    return math.dist(tip, detection.tip_px) / finger.px_per_mm
