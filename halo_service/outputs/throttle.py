"""A lower frame rate for one stream, without losing a touch.

Rule: pure; time is the frame's. A frame is sent when it is due, or at once when a touch begins or
ends in it. Frames are numbered anew, so that a client does not count the others as lost, and each
event is in three of the frames that are sent, and once more where the service sends a late copy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import halo_protocol as wire
from halo_service.outputs.outgoing import OutgoingFrame

COPIES = 3
"""Frames that carry an event."""
MOST_EVENTS = 512
"""Reported events that are remembered, so that a repeated one is not new."""
SLACK_US = 2000
"""A frame so little early is due: sources jitter."""


@dataclass(slots=True)
class _Event:
    message: wire.Down | wire.Up
    time_us: int
    copies: int = COPIES


class Throttle:
    """Chooses and renumbers the frames of one stream."""

    def __init__(self, rate_hz: float) -> None:
        self._period_us = 1e6 / rate_hz
        self._due_us = self._last_us = float("-inf")
        self._number: int | None = None
        self._pending: list[_Event] = []
        self._known: dict[tuple[type, int, int], None] = {}

    def take(self, frame: OutgoingFrame) -> OutgoingFrame | None:
        """Return the frame to send instead of this one, or None."""
        now_us = frame.header.time_us
        new = self._collect(frame, now_us)
        if now_us < self._last_us:  # a recording started again
            self._due_us = float("-inf")
        self._last_us = now_us
        due = now_us >= self._due_us - SLACK_US
        if due:
            self._due_us += self._period_us
            if self._due_us < now_us:
                self._due_us = now_us + self._period_us
        elif not new:
            return None
        return self._numbered(frame, now_us)

    def _collect(self, frame: OutgoingFrame, now_us: int) -> bool:
        """Remember events that were not in an earlier frame; whether there is any.

        A known event that is not pending is a late copy: it goes out with the next frame.
        """
        new = False
        pending = {_key(each.message) for each in self._pending}
        events: tuple[wire.Down | wire.Up, ...] = (*frame.downs, *frame.ups)
        for event in events:
            key = _key(event)
            if key in pending:
                continue
            copies = 1 if key in self._known else COPIES
            new = new or key not in self._known
            self._known[key] = None
            self._pending.append(_Event(event, now_us - round(event.ago_ms * 1000), copies))
        while len(self._known) > MOST_EVENTS:
            del self._known[next(iter(self._known))]
        return new

    def _numbered(self, frame: OutgoingFrame, now_us: int) -> OutgoingFrame:
        first = frame.header.frame
        self._number = first if self._number is None else wire.next_frame(self._number)
        messages = []
        for event in self._pending:
            event.copies -= 1
            messages.append(replace(event.message, ago_ms=(now_us - event.time_us) / 1000.0))
        self._pending = [event for event in self._pending if event.copies > 0]
        return replace(
            frame,
            header=replace(frame.header, frame=self._number),
            downs=tuple(each for each in messages if isinstance(each, wire.Down)),
            ups=tuple(each for each in messages if isinstance(each, wire.Up)),
        )


def _key(event: wire.Down | wire.Up) -> tuple[type, int, int]:
    return type(event), event.id, event.contacts
