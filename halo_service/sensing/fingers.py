"""What is remembered of a finger from frame to frame, and which sighting is which finger."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import count

from halo_service.sensing.debounce import Debounce
from halo_service.sensing.detector import Detector
from halo_service.sensing.pointers import Motion
from halo_service.sensing.sightings import Pixel, Sighting
from halo_service.values import Pointer, TouchEvent

SAME_FINGER_PX = 80.0
"""A sighting farther than this from a finger's tip is another finger (8 cm at 0.5 m)."""
REMEMBERED = 8
"""Tips kept a finger: the slowest tracker's lag at 30 frames a second."""
GAP_FRAMES = 2.0
"""Over a gap in time a finger is carried on for at most this many of its last steps."""


@dataclass(frozen=True, slots=True)
class Past:
    """Where a tip was."""

    time_us: int
    tip_px: Pixel


@dataclass(frozen=True, slots=True)
class Memory:
    """One finger, from when it is first seen until it is gone."""

    id: int
    slot: int
    sighting: Sighting
    """The tracker's last word on it."""
    pointer: Pointer | None = None
    """As last published; None for a newcomer."""
    path: tuple[Past, ...] = ()
    """Its tips, oldest first, at most `REMEMBERED`."""
    detector: Detector | None = None
    debounce: Debounce = Debounce()  # noqa: RUF009 - frozen, so one default serves all
    motion: Motion = Motion()  # noqa: RUF009


def moved_since(path: tuple[Past, ...], since_us: int, time_us: int) -> Pixel:
    """Return how far a tip has gone from one time to another, px; carried on at its last speed."""
    if not path:
        return 0.0, 0.0
    then = _at(path, since_us).tip_px
    last, before = path[-1], path[max(len(path) - 2, 0)]
    steps = (time_us - last.time_us) / max(last.time_us - before.time_us, 1)
    ahead = min(steps, GAP_FRAMES) if len(path) > 1 else 0.0
    return (
        last.tip_px[0] - then[0] + ahead * (last.tip_px[0] - before.tip_px[0]),
        last.tip_px[1] - then[1] + ahead * (last.tip_px[1] - before.tip_px[1]),
    )


def meet(live: tuple[Memory, ...], seen: tuple[Sighting, ...], next_id: int) -> tuple[Memory, ...]:
    """Give the live fingers their new sightings, nearest first, and take up the newcomers."""
    distances = sorted(
        (distance, i, j)
        for i, memory in enumerate(live)
        for j, sighting in enumerate(seen)
        if (distance := _distance(memory, sighting)) < SAME_FINGER_PX
    )
    paired: dict[int, int] = {}
    for _, i, j in distances:
        if i not in paired and j not in paired.values():
            paired[i] = j
    known = tuple(
        replace(memory, sighting=seen[paired[i]]) if i in paired else memory
        for i, memory in enumerate(live)
    )
    strangers = [s for j, s in enumerate(seen) if j not in paired.values()]
    slots = (slot for slot in count() if slot not in {memory.slot for memory in live})
    ids = count(next_id)
    return known + tuple(Memory(*newcomer) for newcomer in zip(ids, slots, strangers, strict=False))


def _at(path: tuple[Past, ...], time_us: int) -> Past:
    return min(path, key=lambda past: abs(past.time_us - time_us))


def _distance(memory: Memory, sighting: Sighting) -> float:
    return math.dist(_at(memory.path, sighting.time_us).tip_px, sighting.tip_px)


def changes(before: Memory, now: Memory | None) -> tuple[TouchEvent, ...]:
    """Return the event between two frames of one finger: at most one.

    A finger that goes (`now` is None) while it touches owes an up: no touch sticks.
    """
    touched = before.debounce.contact.touching
    touching = now is not None and now.debounce.contact.touching
    after = now or before
    pointer = after.pointer
    if touched == touching or pointer is None:
        return ()
    return (
        TouchEvent(
            kind="down" if touching else "up",
            id=after.id,
            slot=after.slot,
            x_mm=pointer.x_mm,
            y_mm=pointer.y_mm,
            strike_mm_s=max(before.motion.descent_mm_s, 0.0) if touching else 0.0,
            ago_ms=after.debounce.contact.ago_us / 1000.0 if now else 0.0,
            contacts=pointer.contacts,
        ),
    )
