"""Which packets of a recording belong to one capture.

Rule: pure, and bounded. Packets come in roughly by time, each track on its own. A capture is all
within half a frame period of its depth packet, and has the time of that packet.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

Track = Literal["DEPTH", "IR", "COLOR"]
"""The tracks by the titles that the Azure Kinect SDK gives them."""
T = TypeVar("T")

# The SDK and every muxer sort packets by time, so a partner comes within a packet or two;
# four periods tolerate an unsorted file and still detect a missing packet soon.
LOOK_AHEAD_PERIODS = 4
LOOK_AHEAD_PACKETS = 32
"""At most this many wait in memory, whatever the timestamps are (raw depth: 0.7 MB each)."""


@dataclass(frozen=True, slots=True)
class Capture(Generic[T]):
    """The packets of one moment, at least one of them."""

    time_us: int
    """The depth packet's timestamp; without one the IR's, else the colour's."""
    depth: T | None
    ir: T | None
    colour: T | None


@dataclass(frozen=True, slots=True)
class _Waiting(Generic[T]):
    track: Track
    time_us: int
    """As stamped."""
    moment_us: int
    """On the depth camera's schedule: for colour, without its configured delay."""
    packet: T


class Pairing(Generic[T]):
    """Packets in, captures out, in the order of time."""

    def __init__(
        self, tracks: frozenset[Track], period_us: float, *, depth_delay_us: float = 0.0
    ) -> None:
        """`tracks`: those that a whole capture has; `depth_delay_us`: of depth after colour."""
        self._tracks = tracks
        self._half_period_us = period_us / 2
        self._look_ahead_us = period_us * LOOK_AHEAD_PERIODS
        self._depth_delay_us = depth_delay_us
        self._waiting: list[_Waiting[T]] = []

    def push(self, track: Track, time_us: int, packet: T) -> Iterator[Capture[T]]:
        """Add the next packet; yield the captures that are complete."""
        delay_us = self._depth_delay_us if track == "COLOR" else 0.0
        self._waiting.append(_Waiting(track, time_us, round(time_us + delay_us), packet))
        while self._waiting:
            group = self._group(min(self._waiting, key=lambda w: w.moment_us))
            if len(group) < len(self._tracks) and not self._waited_enough():
                return
            yield self._take(group)

    def flush(self) -> Iterator[Capture[T]]:
        """Yield what still waits, complete or not: the recording has ended."""
        while self._waiting:
            yield self._take(self._group(min(self._waiting, key=lambda w: w.moment_us)))

    def _waited_enough(self) -> bool:
        moments = [w.moment_us for w in self._waiting]
        late = max(moments) - min(moments) > self._look_ahead_us
        return late or len(self._waiting) > LOOK_AHEAD_PACKETS

    def _group(self, first: _Waiting[T]) -> dict[Track, _Waiting[T]]:
        depth = self._nearest("DEPTH", first)
        anchor = first if depth is None else depth
        group: dict[Track, _Waiting[T]] = {}
        for track in self._tracks:
            found = self._nearest(track, anchor)
            if found is not None:
                group[track] = found
        return group

    def _nearest(self, track: Track, anchor: _Waiting[T]) -> _Waiting[T] | None:
        def distance(waiting: _Waiting[T]) -> int:
            return abs(waiting.moment_us - anchor.moment_us)

        near = [w for w in self._waiting if w.track == track and distance(w) < self._half_period_us]
        return min(near, key=distance, default=None)

    def _take(self, group: dict[Track, _Waiting[T]]) -> Capture[T]:
        self._waiting = [w for w in self._waiting if w is not group.get(w.track)]
        depth, ir, colour = group.get("DEPTH"), group.get("IR"), group.get("COLOR")
        ruler = depth or ir or colour
        assert ruler is not None, "a group holds at least its first packet"
        return Capture(
            ruler.time_us,
            depth.packet if depth else None,
            ir.packet if ir else None,
            colour.packet if colour else None,
        )
