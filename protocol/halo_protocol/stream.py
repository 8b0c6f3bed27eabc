"""Assembles the frames of one session on one surface from their parts.

Rule: a frame is reported once, whole if all its parts arrived, and never after a newer one.
"""

from __future__ import annotations

from dataclasses import replace

from halo_protocol.checks import MAX_EVENTS
from halo_protocol.counter import ahead, is_newer
from halo_protocol.events import Lost, TouchFrame
from halo_protocol.parts import Part
from halo_protocol.touch_counter import TouchCounter

JOIN_MS = 200.0
"""An event so long before the first frame that a client receives was before it joined: it is a late
copy. The first three copies come within this time."""


class Stream:
    """State of one (node, surface, session)."""

    def __init__(self, part: Part, now_s: float) -> None:
        self.surface = part.surface
        self.node = part.header.node
        self.session = part.header.session
        self.first_s = now_s
        """Arrival of its first datagram, on the caller's clock."""
        self.received_s = now_s
        """Arrival of its last datagram."""
        self.dropped = 0
        """Parts that were old, duplicate, or contradicted their frame."""
        self._touches = TouchCounter()
        self._joined_us = part.header.time_us
        self._joining = True
        """True until a whole frame was reported."""
        self._last: TouchFrame | None = None
        self._pending: Part | None = None

    @property
    def holds_pointers(self) -> bool:
        """Whether its last frame has pointers."""
        return self._last is not None and bool(self._last.pointers)

    def receive(self, part: Part, now_s: float) -> list[TouchFrame]:
        """The frames that this part completes, or proves incomplete."""
        self.received_s = now_s
        age_ms = (part.header.time_us - self._joined_us) / 1000.0
        part.events = [each for each in part.events if each.ago_ms <= age_ms + JOIN_MS]
        if self._last is not None and not is_newer(part.header.frame, self._last.frame):
            return self._late_events(part, self._last)
        frames = []
        if self._pending is None:
            self._pending = part
        elif is_newer(part.header.frame, self._pending.header.frame):
            frames.append(self._report(self._pending, complete=False))
            self._pending = part
        elif not self._merge(self._pending, part):
            self.dropped += 1
            return []
        if len(self._pending.pointers) == self._pending.header.count:
            frames.append(self._report(self._pending, complete=True))
            self._pending = None
        return frames

    def close(self) -> list[TouchFrame | Lost]:
        """The last events of a lost session: no pointers, open touches ended."""
        events: list[TouchFrame | Lost] = []
        ups = self._touches.close()
        if self._last is not None and (self._last.pointers or ups):
            events.append(
                replace(self._last, pointers=(), downs=(), ups=ups, missed=0, complete=True)
            )
        return [*events, Lost(self.surface, self.node, self.session)]

    def _merge(self, pending: Part, part: Part) -> bool:
        """Add a part to its frame; False if it belongs to another frame or adds nothing."""
        new_pointers = part.pointers.keys() - pending.pointers.keys()
        new_events = [event for event in part.events if event not in pending.events]
        if not part.agrees_with(pending) or not (new_pointers or new_events):
            return False
        if len(pending.events) + len(new_events) > MAX_EVENTS:
            return False
        pending.pointers |= part.pointers
        pending.events += new_events
        return True

    def _late_events(self, part: Part, last: TouchFrame) -> list[TouchFrame]:
        """Late events of a frame that was already reported."""
        if part.header.frame == last.frame and part.events:
            downs, ups = self._touches.count(last.pointers, part.events)
            if downs or ups:
                return [replace(last, downs=downs, ups=ups, missed=0)]
        self.dropped += 1
        return []

    def _report(self, part: Part, *, complete: bool) -> TouchFrame:
        header, last = part.header, self._last
        known = {pointer.id: pointer for pointer in last.pointers} if last else {}
        known |= part.pointers
        pointers = tuple(known[key] for key in part.ids if key in known)
        downs, ups = self._touches.count(
            pointers, part.events, joining=self._joining, whole=complete
        )
        self._joining = self._joining and not complete
        self._last = TouchFrame(
            self.surface,
            self.node,
            self.session,
            header.frame,
            header.time_us,
            pointers,
            downs,
            ups,
            missed=ahead(header.frame, last.frame) - 1 if last else 0,
            complete=complete,
            session_ms=header.session_ms,
        )
        return self._last
