"""Where the time of each frame goes, from its arrival to the sending of its packet.

Rule: laps leave no gap, so the stages of a frame add up to its latency.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from halo_service.values import TouchEvent, TouchFrame


@dataclass(frozen=True, slots=True)
class Row:
    """One published frame."""

    time_us: int
    """On the frames' clock."""
    stages_ns: Mapping[str, int]
    """By name, in the order in which they came."""
    events: tuple[TouchEvent, ...]
    """The events in its packet."""

    @property
    def latency_ns(self) -> int:
        """From received to sent."""
        return sum(self.stages_ns.values())


class Stopwatch:
    """Times one frame after the other. Used from one thread."""

    def __init__(self) -> None:
        self.rows: list[Row] = []
        self.extra_packets = 0
        """Packets without a frame: the loop's last one."""
        self._time_us: int | None = None
        """Of the frame on its way; None between frames."""
        self._lap_ns = 0
        self._stages: dict[str, int] = {}

    def begin(self, time_us: int, received_ns: int) -> None:
        """Start with a frame that arrived at `received_ns` of `time.perf_counter_ns`."""
        self._time_us, self._lap_ns, self._stages = time_us, received_ns, {}

    def lap(self, stage: str) -> None:
        """End a stage; between frames there is none."""
        if self._time_us is None:
            return
        now_ns = time.perf_counter_ns()
        self._stages[stage] = self._stages.get(stage, 0) + now_ns - self._lap_ns
        self._lap_ns = now_ns

    def end(self, frame: TouchFrame) -> None:
        """The frame's packet was sent at the last lap."""
        if self._time_us is None:
            self.extra_packets += 1
        else:
            self.rows.append(Row(self._time_us, self._stages, frame.events))
        self._time_us = None


class Carries(Protocol):
    """What sends frames and reports: an output's carrier."""

    def send(self, outgoing: Any) -> None:
        """Send one; `outgoing` has a `kind` and, encoded when first read, its `datagrams`."""

    def close(self) -> None:
        """Release the socket."""


class TimedCarrier:
    """A carrier with laps: the frame is encoded before it and sent in it."""

    def __init__(self, carrier: Carries, watch: Stopwatch) -> None:
        self._carrier = carrier
        self._watch = watch

    def send(self, outgoing: Any) -> None:
        """Send on."""
        if outgoing.kind != "frame":
            self._carrier.send(outgoing)
            return
        assert outgoing.datagrams  # encoded here
        self._watch.lap("encode")
        self._carrier.send(outgoing)
        self._watch.lap("send")

    def close(self) -> None:
        """Close the carrier."""
        self._carrier.close()
