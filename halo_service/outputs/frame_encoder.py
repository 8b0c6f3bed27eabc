"""Encodes the service's frames as protocol messages.

Rule: no I/O and no clock. Its only state is the frame number and the few events it repeats.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace

import halo_protocol as wire
from halo_service.outputs.outgoing import OutgoingFrame
from halo_service.values import Pointer, TouchEvent, TouchFrame

REPEATS = 2
"""An event is sent in its own frame and in the next two, so one lost datagram hides none."""

MOST_LATER = 64
"""Events that wait to be sent once more."""


class FrameEncoder:
    """Numbers the frames of one session and repeats recent events."""

    def __init__(
        self,
        node: str,
        session: str,
        first_frame: int,
        max_bytes: int = wire.MAX_BUNDLE,
        again_ms: float = 0.0,
    ) -> None:
        """`first_frame`: from `halo_protocol.first_frame` when live, 0 in replay.

        `max_bytes`: of a bundle; `again_ms`: when each event is sent once more, see `OscSettings`.
        `ProtocolError` for a bad name.
        """
        self.node = wire.check_name(node, "node")
        self.session = wire.check_session(session)
        self._next_frame = first_frame
        self._max_bytes = max_bytes
        self._start_us: int | None = None
        self._past: deque[list[tuple[int, TouchEvent]]] = deque(maxlen=REPEATS)
        self._again_us = again_ms * 1000.0
        self._later: deque[tuple[int, TouchEvent]] = deque(maxlen=MOST_LATER)

    def encode(self, touch_frame: TouchFrame) -> OutgoingFrame:
        """Convert a frame, with the events of the two before it."""
        repeated = [
            replace(past, ago_ms=past.ago_ms + (touch_frame.time_us - since_us) / 1000.0)
            for since_us, past in (
                *(pair for frame in self._past for pair in frame),
                *self._due_again(touch_frame.time_us),
            )
        ]
        if self._start_us is None:
            self._start_us = touch_frame.time_us
        new = [(touch_frame.time_us, event) for event in touch_frame.events]
        self._past.append(new)
        self._later.extend(new if self._again_us else ())
        downs, ups = event_messages([*touch_frame.events, *repeated], touch_frame)
        header = wire.Frame(
            self.node,
            self.session,
            self._next_frame,
            *divmod(touch_frame.time_us, 1_000_000),
            len(touch_frame.pointers),
            wire.session_ms(touch_frame.time_us, self._start_us),
        )
        self._next_frame = wire.next_frame(self._next_frame)
        return OutgoingFrame(
            touch_frame.surface,
            (touch_frame.width_mm, touch_frame.height_mm),
            header,
            tuple(pointer_message(pointer, touch_frame) for pointer in touch_frame.pointers),
            tuple(downs),
            tuple(ups),
            self._max_bytes,
        )

    def _due_again(self, now_us: int) -> Iterator[tuple[int, TouchEvent]]:
        """Yield the events that are sent for the last time; none after time went back."""
        while self._later and not 0 <= now_us - self._later[0][0] < self._again_us:
            since_us, event = self._later.popleft()
            if since_us <= now_us:
                yield since_us, event


def pointer_message(pointer: Pointer, touch_frame: TouchFrame) -> wire.Pointer:
    """Convert a pointer to its wire message."""
    return wire.Pointer(
        id=pointer.id,
        slot=pointer.slot,
        hand=pointer.side,
        finger=pointer.finger,
        state=pointer.state,
        u=pointer.x_mm / touch_frame.width_mm,
        v=pointer.y_mm / touch_frame.height_mm,
        x_mm=pointer.x_mm,
        y_mm=pointer.y_mm,
        hover_mm=pointer.hover_mm,
        pressure=pointer.pressure,
        vx_mm_s=pointer.vx_mm_s,
        vy_mm_s=pointer.vy_mm_s,
        confidence=pointer.confidence,
        contacts=pointer.contacts,
        force_g=pointer.force_g,
    )


def event_messages(
    events: Iterable[TouchEvent], touch_frame: TouchFrame
) -> tuple[list[wire.Down], list[wire.Up]]:
    """Convert events to their wire messages: (downs, ups)."""
    downs: list[wire.Down] = []
    ups: list[wire.Up] = []
    for e in events:
        u, v = e.x_mm / touch_frame.width_mm, e.y_mm / touch_frame.height_mm
        if e.kind == "down":
            downs.append(wire.Down(e.id, e.slot, u, v, e.strike_mm_s, e.ago_ms, e.contacts))
        else:
            ups.append(wire.Up(e.id, e.slot, u, v, e.ago_ms, e.contacts))
    return downs, ups
