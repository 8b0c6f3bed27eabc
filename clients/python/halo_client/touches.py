"""From frames to touches: one begins, it moves, it ends.

Rule: pure, and nothing is remembered: the assembler has counted each touch once, made up what
was lost, and ended what its service left open. Whoever joins in mid-touch is told of moves first.
"""

from __future__ import annotations

from dataclasses import dataclass

from halo_protocol import Down, Pointer, TouchFrame, Up


@dataclass(frozen=True, slots=True)
class TouchKey:
    """Names one touch among all that any service ever tells."""

    node: str
    surface: str
    session: str
    id: int
    contacts: int


@dataclass(frozen=True, slots=True)
class Began:
    """A finger came down."""

    key: TouchKey
    time_us: int
    """When it came down, on the clock of the frames."""
    down: Down
    pointer: Pointer | None
    """The finger in the frame that tells of it; None where it has left by then."""


@dataclass(frozen=True, slots=True)
class Moved:
    """A finger is still down."""

    key: TouchKey
    time_us: int
    pointer: Pointer


@dataclass(frozen=True, slots=True)
class Ended:
    """A finger was lifted, or lost."""

    key: TouchKey
    time_us: int
    up: Up


Touch = Began | Moved | Ended


def touches(frame: TouchFrame) -> list[Touch]:
    """What a frame tells of touches, those of each finger in the order in which they happened."""
    living = {pointer.id: pointer for pointer in frame.pointers}
    told: list[Touch] = []
    for event in frame.events:
        key = _key(frame, event)
        time_us = frame.time_us - round(event.ago_ms * 1000)
        if isinstance(event, Up):
            told.append(Ended(key, time_us, event))
        else:
            told.append(Began(key, time_us, event, living.get(event.id)))
    settled = {touch.key for touch in told}
    for pointer in frame.pointers:
        key = _key(frame, pointer)
        if pointer.touching and key not in settled:
            told.append(Moved(key, frame.time_us, pointer))
    return told


def _key(frame: TouchFrame, seen: Down | Up | Pointer) -> TouchKey:
    return TouchKey(frame.node, frame.surface, frame.session, seen.id, seen.contacts)
