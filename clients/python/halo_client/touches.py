"""Converts frames to touches, which begin, move and end.

Rule: pure, without state: the assembler counts each touch once, infers lost events, and ends
the touches of a lost service. A client that joins during a touch gets `Moved` first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from halo_protocol import Down, Event, Pointer, TouchFrame, Up


@dataclass(frozen=True, slots=True)
class TouchKey:
    """Identifies one touch among those of all services."""

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
    """Time of contact, on the clock of the frames."""
    down: Down
    pointer: Pointer | None
    """The finger in the same frame; None if it has already left."""


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
    """The touches of a frame; those of one finger in order of time."""
    living = {pointer.id: pointer for pointer in frame.pointers}
    found: list[Touch] = []
    for event in frame.events:
        key = _key(frame, event)
        time_us = frame.time_us - round(event.ago_ms * 1000)
        if isinstance(event, Up):
            found.append(Ended(key, time_us, event))
        else:
            found.append(Began(key, time_us, event, living.get(event.id)))
    reported = {touch.key for touch in found}
    for pointer in frame.pointers:
        key = _key(frame, pointer)
        if pointer.touching and key not in reported:
            found.append(Moved(key, frame.time_us, pointer))
    return found


def _key(frame: TouchFrame, item: Down | Up | Pointer) -> TouchKey:
    return TouchKey(frame.node, frame.surface, frame.session, item.id, item.contacts)


@dataclass(slots=True)
class Callbacks:
    """Functions that are called with touches, in the order in which they were added."""

    down: list[Callable[[Began], object]] = field(default_factory=list)
    move: list[Callable[[Moved], object]] = field(default_factory=list)
    up: list[Callable[[Ended], object]] = field(default_factory=list)

    def call(self, events: Iterable[Event]) -> None:
        """Call the functions with the touches of the frames among events."""
        if not (self.down or self.move or self.up):
            return
        for event in events:
            if isinstance(event, TouchFrame):
                for touch in touches(event):
                    self._call(touch)

    def _call(self, touch: Touch) -> None:
        if isinstance(touch, Began):
            for begin in self.down:
                begin(touch)
        elif isinstance(touch, Moved):
            for move in self.move:
                move(touch)
        else:
            for end in self.up:
                end(touch)
