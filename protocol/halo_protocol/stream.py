"""The frames of one session on one surface, put together from their parts.

Rule: a frame is told once, whole if all of its parts came, and never after a newer one.
"""

from __future__ import annotations

from dataclasses import replace

from halo_protocol.checks import MAX_EVENTS
from halo_protocol.counter import ahead, is_newer
from halo_protocol.events import Lost, TouchFrame
from halo_protocol.parts import Part
from halo_protocol.tally import Tally


class Stream:
    """State of one (node, surface, session)."""

    def __init__(self, part: Part, now_s: float) -> None:
        self.surface = part.surface
        self.node = part.header.node
        self.session = part.header.session
        self.heard_s = now_s
        """When its last datagram came, on the caller's clock."""
        self.dropped = 0
        """Parts that were old, came twice, or contradicted their frame."""
        self._tally = Tally()
        self._joining = True
        """Until a whole frame was told."""
        self._told: TouchFrame | None = None
        self._pending: Part | None = None

    @property
    def holds_pointers(self) -> bool:
        """Whether a client would draw something of it now."""
        return self._told is not None and bool(self._told.pointers)

    def receive(self, part: Part, now_s: float) -> list[TouchFrame]:
        """The frames that this part completes, or shows to be incomplete for good."""
        self.heard_s = now_s
        if self._told is not None and not is_newer(part.header.frame, self._told.frame):
            return self._after_the_fact(part, self._told)
        frames = []
        if self._pending is None:
            self._pending = part
        elif is_newer(part.header.frame, self._pending.header.frame):
            frames.append(self._tell(self._pending, complete=False))
            self._pending = part
        elif not self._merge(self._pending, part):
            self.dropped += 1
            return []
        if len(self._pending.pointers) == self._pending.header.count:
            frames.append(self._tell(self._pending, complete=True))
            self._pending = None
        return frames

    def close(self) -> list[TouchFrame | Lost]:
        """What a client is told when nothing more is expected: no pointers, open touches ended."""
        events: list[TouchFrame | Lost] = []
        ups = self._tally.close()
        if self._told is not None and (self._told.pointers or ups):
            events.append(
                replace(self._told, pointers=(), downs=(), ups=ups, missed=0, complete=True)
            )
        return [*events, Lost(self.surface, self.node, self.session)]

    def _merge(self, pending: Part, part: Part) -> bool:
        """Add a part to its frame; False where it belongs to another or brings nothing new."""
        new_pointers = part.pointers.keys() - pending.pointers.keys()
        new_events = [event for event in part.events if event not in pending.events]
        if not part.agrees_with(pending) or not (new_pointers or new_events):
            return False
        if len(pending.events) + len(new_events) > MAX_EVENTS:
            return False
        pending.pointers |= part.pointers
        pending.events += new_events
        return True

    def _after_the_fact(self, part: Part, told: TouchFrame) -> list[TouchFrame]:
        """Events of a frame that was told already, its pointers having been all there."""
        if part.header.frame == told.frame and part.events:
            downs, ups = self._tally.count(told.pointers, part.events)
            if downs or ups:
                return [replace(told, downs=downs, ups=ups, missed=0)]
        self.dropped += 1
        return []

    def _tell(self, part: Part, *, complete: bool) -> TouchFrame:
        header, told = part.header, self._told
        known = {pointer.id: pointer for pointer in told.pointers} if told else {}
        known |= part.pointers
        pointers = tuple(known[key] for key in part.ids if key in known)
        downs, ups = self._tally.count(pointers, part.events, joining=self._joining, whole=complete)
        self._joining = self._joining and not complete
        self._told = TouchFrame(
            self.surface,
            self.node,
            self.session,
            header.frame,
            header.time_us,
            pointers,
            downs,
            ups,
            missed=ahead(header.frame, told.frame) - 1 if told else 0,
            complete=complete,
        )
        return self._told
