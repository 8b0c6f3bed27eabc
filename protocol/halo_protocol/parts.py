"""One datagram as parts of frames and reports.

Rule: a part is whole or refused. It starts with its header, ends with the full alive list, and
is consistent; otherwise `ProtocolError` is raised before any state changes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from halo_protocol.checks import MAX_EVENTS
from halo_protocol.errors import ProtocolError
from halo_protocol.events import Report
from halo_protocol.messages import (
    Alive,
    Down,
    Frame,
    Health,
    Homography,
    Message,
    Pointer,
    Pose,
    Scene,
    Up,
)


@dataclass(slots=True)
class Part:
    """The content of one datagram for one frame."""

    surface: str
    header: Frame
    ids: tuple[int, ...] = ()
    """The frame's pointers, over all parts."""
    pointers: dict[int, Pointer] = field(default_factory=dict)
    """The pointers in this part, by id."""
    events: list[Down | Up] = field(default_factory=list)

    def agrees_with(self, other: Part) -> bool:
        """Whether both can be parts of one frame."""
        return self.header == other.header and self.ids == other.ids

    def add_event(self, event: Down | Up) -> None:
        """Append a down or up."""
        if len(self.events) == MAX_EVENTS:
            raise ProtocolError(f"a frame has at most {MAX_EVENTS} events")
        self.events.append(event)

    def closed(self, ids: tuple[int, ...]) -> Part:
        """This part with its alive list."""
        if len(ids) != self.header.count:
            raise ProtocolError(f"count is {self.header.count}, but {len(ids)} ids are alive")
        if not self.pointers.keys() <= set(ids):
            raise ProtocolError(f"a pointer is not alive: {sorted(self.pointers)}, alive {ids}")
        self.ids = ids
        return self


def parts(messages: Iterable[tuple[str, Message]]) -> list[Part | Report]:
    """Group the messages of one datagram."""
    done: list[Part | Report] = []
    begun: dict[str, Part] = {}
    for surface, message in messages:
        if isinstance(message, Scene | Homography | Pose | Health):
            done.append(Report(surface, message))
        elif isinstance(message, Frame):
            if surface in begun:
                raise ProtocolError(f"a frame of {surface!r} starts before the last one has ended")
            begun[surface] = Part(surface, message)
        elif surface not in begun:
            raise ProtocolError(f"a message of {surface!r} comes before its frame's header")
        elif isinstance(message, Alive):
            done.append(begun.pop(surface).closed(message.ids))
        elif isinstance(message, Pointer):
            if message.id in begun[surface].pointers:
                raise ProtocolError(f"pointer {message.id} comes twice")
            begun[surface].pointers[message.id] = message
        else:
            begun[surface].add_event(message)
    if begun:
        raise ProtocolError(f"the alive list is missing in the frame of {', '.join(begun)}")
    return done
