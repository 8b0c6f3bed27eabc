"""Datagrams in, events out: what a client does between its socket and its picture.

Rule: no I/O and no clock. The caller hands in bytes and the time on any clock that only goes
forward; state is kept for a bounded number of (node, surface, session), so that two services
never delete each other's pointers and no stranger can fill the memory.
"""

from __future__ import annotations

from halo_protocol.codec import decode
from halo_protocol.events import Event, Report
from halo_protocol.parts import Part, parts
from halo_protocol.stream import Stream

TIMEOUT_S = 3.0
"""Silence after which a service is taken for gone; it sends at least once a second."""
SUPERSEDED_S = 0.5
"""Likewise while it had pointers (hence a frame each 33 ms) and its node has a newer session:
it was killed and started anew, and nobody wants to see the old fingers for three seconds."""
MAX_STREAMS = 64
"""Sessions remembered at once; past it the one that was silent for longest is closed."""


class Assembler:
    """One per socket or subscription. Not thread-safe: it belongs to the one who receives."""

    def __init__(self, timeout_s: float = TIMEOUT_S) -> None:
        self._timeout_s = timeout_s
        self._streams: dict[tuple[str, str, str], Stream] = {}
        self._dropped_before = 0

    @property
    def dropped(self) -> int:
        """Parts of frames that were old, came twice, or contradicted their frame."""
        return self._dropped_before + sum(stream.dropped for stream in self._streams.values())

    def receive_data(self, datagram: bytes, now_s: float) -> list[Event]:
        """What a datagram tells, after what has expired by `now_s`.

        `ProtocolError` where the datagram is malformed; nothing has changed then, and the caller
        counts it and goes on.
        """
        arrived = parts(decode(datagram))
        events = self.expire(now_s)
        for item in arrived:
            if isinstance(item, Report):
                events.append(item)
            else:
                events += self._receive(item, now_s)
        return events

    def expire(self, now_s: float) -> list[Event]:
        """Close what has been silent for too long; call it at least a few times a second."""
        newest = {(stream.node, stream.surface): stream for stream in self._streams.values()}
        events: list[Event] = []
        for key, stream in list(self._streams.items()):
            superseded = newest[stream.node, stream.surface] is not stream
            limit_s = self._timeout_s
            if superseded and stream.holds_pointers:
                limit_s = min(limit_s, SUPERSEDED_S)
            if now_s - stream.heard_s > limit_s:
                events += self._close(key)
        return events

    def _receive(self, part: Part, now_s: float) -> list[Event]:
        key = (part.header.node, part.surface, part.header.session)
        events: list[Event] = []
        if key not in self._streams:
            if len(self._streams) >= MAX_STREAMS:
                streams = self._streams
                events += self._close(min(streams, key=lambda key: streams[key].heard_s))
            self._streams[key] = Stream(part, now_s)
        events += self._streams[key].receive(part, now_s)
        return events

    def _close(self, key: tuple[str, str, str]) -> list[Event]:
        stream = self._streams.pop(key)
        self._dropped_before += stream.dropped
        return list(stream.close())
