"""From the house's values to the promise's bytes. Pure but for the few events it repeats."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import halo_protocol as wire
from halo_service.values import Pointer, TouchEvent, TouchFrame

REPEATS = 2
"""An event is told in its own frame and in the next two, so that a lost datagram hides none."""


class Wire:
    """Numbers the frames of one session and keeps repeating what is new."""

    def __init__(self, node: str, session: str, first_frame: int) -> None:
        """`first_frame`: from `halo_protocol.counter` when live, 0 in replay."""
        self.node = node
        self.session = session
        self._next_frame = first_frame
        self._past: deque[list[tuple[int, TouchEvent]]] = deque(maxlen=REPEATS)

    def frame(self, told: TouchFrame) -> list[bytes]:
        """Encode a frame, and the events of the two before it."""
        repeated = [
            replace(past, ago_ms=past.ago_ms + (told.time_us - since_us) / 1000.0)
            for since_us, past in (pair for frame in self._past for pair in frame)
        ]
        self._past.append([(told.time_us, event) for event in told.events])
        downs, ups = event_messages([*told.events, *repeated], told)
        header = wire.Frame(
            self.node,
            self.session,
            self._next_frame,
            *divmod(told.time_us, 1_000_000),
            len(told.pointers),
        )
        self._next_frame = wire.next_frame(self._next_frame)
        return wire.encode_frame(
            told.surface,
            header,
            [pointer_message(pointer, told) for pointer in told.pointers],
            downs,
            ups,
        )


def pointer_message(pointer: Pointer, told: TouchFrame) -> wire.Pointer:
    """Say a pointer as the wire says it."""
    return wire.Pointer(
        id=pointer.id,
        slot=pointer.slot,
        hand=pointer.side,
        finger=pointer.finger,
        state=pointer.state,
        u=pointer.x_mm / told.width_mm,
        v=pointer.y_mm / told.height_mm,
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
    events: Iterable[TouchEvent], told: TouchFrame
) -> tuple[list[wire.Down], list[wire.Up]]:
    """Say events as the wire says them."""
    downs: list[wire.Down] = []
    ups: list[wire.Up] = []
    for e in events:
        u, v = e.x_mm / told.width_mm, e.y_mm / told.height_mm
        if e.kind == "down":
            downs.append(wire.Down(e.id, e.slot, u, v, e.strike_mm_s, e.ago_ms, e.contacts))
        else:
            ups.append(wire.Up(e.id, e.slot, u, v, e.ago_ms, e.contacts))
    return downs, ups
