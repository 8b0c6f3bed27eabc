"""Datagrams in, events out: the receiving half of a client.

Rule: no I/O and no clock. The caller passes bytes and the time on a monotonic clock. State is
separate for each (node, surface, session), so two services never delete each other's
pointers, and bounded, so forged datagrams cannot fill the memory.
"""

from __future__ import annotations

from halo_protocol.codec import decode
from halo_protocol.events import Collision, Event, Report
from halo_protocol.parts import Part, parts
from halo_protocol.stream import Stream

TIMEOUT_S = 3.0
"""Silence after which a service counts as lost; it sends at least once a second."""
SUPERSEDED_S = 0.5
"""The same for a session with pointers (it sends a frame every 33 or 67 ms) when its node has a
newer session: the service was killed and restarted, and the old fingers must not stay for 3 s.
Likewise when its node has left."""
MAX_STREAMS = 64
"""Sessions at the same time; beyond, the one that was silent for longest is closed."""


class Assembler:
    """One per socket or subscription. Not thread-safe."""

    def __init__(self, timeout_s: float = TIMEOUT_S) -> None:
        self._timeout_s = timeout_s
        self._streams: dict[tuple[str, str, str], Stream] = {}
        self._ranks: dict[tuple[str, str, str], int] = {}
        self._collisions: set[tuple[str, str, str, str]] = set()
        self._dropped_before = 0
        self.left: frozenset[str] = frozenset()
        """Nodes that have left the network, where the caller knows: Zenoh's liveliness tokens."""

    @property
    def dropped(self) -> int:
        """Parts of frames that were old, duplicate, or contradicted their frame."""
        return self._dropped_before + sum(stream.dropped for stream in self._streams.values())

    def receive_data(self, datagram: bytes, now_s: float) -> list[Event]:
        """The events of a datagram, after those of sessions that have expired by `now_s`.

        `ProtocolError` for a malformed datagram; the state is unchanged then, and the caller
        counts it and continues.
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
        """Close sessions that were silent for too long; call it a few times a second."""
        newest = self._newest()
        events: list[Event] = []
        for key, stream in list(self._streams.items()):
            superseded = newest[stream.node, stream.surface] is not stream
            limit_s = self._timeout_s
            if (superseded or stream.node in self.left) and stream.holds_pointers:
                limit_s = min(limit_s, SUPERSEDED_S)
            if now_s - stream.received_s > limit_s:
                events += self._close(key)
        return events

    def _receive(self, part: Part, now_s: float) -> list[Event]:
        key = (part.header.node, part.surface, part.header.session)
        events: list[Event] = []
        if key not in self._streams:
            if len(self._streams) >= MAX_STREAMS:
                streams = self._streams
                events += self._close(min(streams, key=lambda key: streams[key].received_s))
            self._streams[key] = Stream(part, now_s)
            self._rank(key)
        frames = self._streams[key].receive(part, now_s)
        if frames:
            events += self._collision(self._streams[key], now_s)
        return [*events, *frames]

    def _newest(self) -> dict[tuple[str, str], Stream]:
        """The session of each (node, surface) that started last, by first arrival."""
        streams = sorted(self._streams.items(), key=lambda item: self._ranks[item[0]])
        return {(stream.node, stream.surface): stream for _, stream in streams}

    def _rank(self, key: tuple[str, str, str]) -> None:
        """Number sessions by first arrival; one that comes back keeps its number."""
        rank = self._ranks.pop(key, max(self._ranks.values(), default=0) + 1)
        self._ranks[key] = rank
        closed = [each for each in self._ranks if each not in self._streams]
        for each in closed[: max(0, len(closed) - MAX_STREAMS)]:
            del self._ranks[each]

    def _collision(self, stream: Stream, now_s: float) -> list[Event]:
        """A collision if an older session still sends frames well after a newer one began.

        Late datagrams of a killed service arrive within `SUPERSEDED_S`.
        """
        newest = self._newest()[stream.node, stream.surface]
        pair = (stream.node, stream.surface, stream.session, newest.session)
        late = now_s - newest.first_s <= SUPERSEDED_S
        if stream is newest or late or pair in self._collisions:
            return []
        self._collisions.add(pair)
        return [Collision(stream.surface, stream.node, (stream.session, newest.session))]

    def close(self, node: str, surface: str, session: str) -> list[Event]:
        """End a session now: its open touches end, and it is reported as lost."""
        key = (node, surface, session)
        return self._close(key) if key in self._streams else []

    def _close(self, key: tuple[str, str, str]) -> list[Event]:
        stream = self._streams.pop(key)
        self._dropped_before += stream.dropped
        node, surface, session = key
        self._collisions = {
            pair
            for pair in self._collisions
            if pair[:2] != (node, surface) or session not in pair[2:]
        }
        return list(stream.close())
