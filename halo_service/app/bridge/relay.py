"""Makes what a receiver reports of one node the messages that the service has sent.

Rule: pure; no I/O and no clock. A receiver reports each touch once. The copies of its `down` and
`up` are read from the datagrams, so that a client of the bridge gets the bytes of the service.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import halo_protocol as wire
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame, OutgoingReport, Reported

SIZE_MM = (300.0, 200.0)
"""Size of a surface until its scene arrives, at most half a second; TUIO's velocities need it."""
COPIES = 3
"""Frames without pointers after a node is lost: they carry the `up` of each open touch."""
MOST_FRAMES = 8
"""Frames with parts that wait for others; the oldest is dropped."""

Key = tuple[str, str, str, int]
"""(surface, node, session, frame)."""


class Relay:
    """One surface of one node at a time."""

    def __init__(self, max_bytes: int = wire.MAX_BUNDLE, *, with_node: bool = False) -> None:
        """`max_bytes`: of a bundle; `with_node`: surfaces are called NODE-SURFACE."""
        self._max_bytes = max_bytes
        self._with_node = with_node
        self._copies: dict[Key, list[wire.Down | wire.Up]] = {}
        self._last: wire.TouchFrame | None = None
        self.frames = self.missed = 0
        """Frames that arrived; frames of the same session that were sent and never arrived."""

    def read(self, datagram: bytes) -> None:
        """Remember the downs and ups of a datagram, before its frame is reported."""
        key = None
        try:
            messages = wire.decode(datagram)
        except wire.ProtocolError:
            return  # the receiver counts and logs it
        for surface, message in messages:
            if isinstance(message, wire.Frame):
                key = (surface, message.node, message.session, message.frame)
            elif isinstance(message, wire.Down | wire.Up) and key is not None:
                self._remember(key, message)

    def outgoing(
        self,
        events: Sequence[wire.Event],
        scenes: Mapping[tuple[str, str], wire.Scene],
    ) -> Iterator[Outgoing]:
        """Yield what to send. `scenes`: the latest one of each (node, surface)."""
        for event, following in pairwise([*events, None]):
            if isinstance(event, wire.Report):
                yield self.report(event.surface, event.message)
            elif isinstance(event, wire.TouchFrame):
                scene = scenes.get((event.node, event.surface))
                size_mm = (scene.width_mm, scene.height_mm) if scene else SIZE_MM
                if isinstance(following, wire.Lost):
                    yield from self._end(event, size_mm)
                else:
                    yield self._frame(event, size_mm)

    def report(self, surface: str, message: Reported) -> OutgoingReport:
        """Return a report under the name that its surface has here."""
        return OutgoingReport(self._name(message.node, surface), message)

    def _frame(self, frame: wire.TouchFrame, size_mm: tuple[float, float]) -> OutgoingFrame:
        self._count(frame)
        events = self._copies.pop((frame.surface, frame.node, frame.session, frame.frame), [])
        downs = tuple(each for each in events if isinstance(each, wire.Down))
        ups = tuple(each for each in events if isinstance(each, wire.Up))
        return self._encoded(frame, size_mm, downs, ups)

    def _end(self, frame: wire.TouchFrame, size_mm: tuple[float, float]) -> Iterator[OutgoingFrame]:
        """Yield frames without pointers, after the last one that the node sent."""
        for _ in range(COPIES):
            frame = replace(frame, frame=wire.next_frame(frame.frame))
            yield self._encoded(frame, size_mm, (), frame.ups)

    def _encoded(
        self,
        frame: wire.TouchFrame,
        size_mm: tuple[float, float],
        downs: tuple[wire.Down, ...],
        ups: tuple[wire.Up, ...],
    ) -> OutgoingFrame:
        header = wire.Frame(
            frame.node,
            frame.session,
            frame.frame,
            *divmod(frame.time_us, 1_000_000),
            len(frame.pointers),
            frame.session_ms,
        )
        name = self._name(frame.node, frame.surface)
        return OutgoingFrame(name, size_mm, header, frame.pointers, downs, ups, self._max_bytes)

    def _count(self, frame: wire.TouchFrame) -> None:
        """Count it, and the gap before it, also where the node was lost in between."""
        last, self._last = self._last, frame
        self.frames += 1
        if last is None or (last.node, last.session) != (frame.node, frame.session):
            return
        if wire.is_newer(frame.frame, last.frame):
            self.missed += wire.ahead(frame.frame, last.frame) - 1

    def _remember(self, key: Key, event: wire.Down | wire.Up) -> None:
        copies = self._copies.setdefault(key, [])
        if event not in copies and len(copies) < wire.MAX_EVENTS:
            copies.append(event)
        while len(self._copies) > MOST_FRAMES:
            del self._copies[next(iter(self._copies))]

    def _name(self, node: str, surface: str) -> str:
        return f"{node}-{surface}" if self._with_node else surface
