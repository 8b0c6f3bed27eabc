"""One run: the two arrangements take turns over the same frames, so that noise affects both."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

from halo_service.evaluation.latency.listener import Listener, Received
from halo_service.evaluation.latency.raw_frames import PacedSource
from halo_service.evaluation.latency.sequential import Sequential
from halo_service.evaluation.latency.simulate import LatencyRecording
from halo_service.evaluation.latency.stopwatch import Row, Stopwatch
from halo_service.runtime.health import Health
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.live import Publisher as Publishes
from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.sensing import State
from halo_service.sources import Source
from halo_service.values import TouchFrame

Arrangement = Literal["ours", "sequential"]
STARTING_S = 0.05
"""Interval between two looks at a starting tracker."""
SCHEDSTAT = Path("/proc/thread-self/schedstat")
"""Linux: nanoseconds on a core, nanoseconds of waiting for one, and how often."""


@dataclass(frozen=True, slots=True)
class Spent:
    """Cost of one block, from its first frame to its last."""

    cpu_ms: float
    """Of all threads."""
    path_cpu_ms: float
    """Of the thread that reads frames and sends packets."""
    core_wait_ms: float | None
    """How long that thread was ready to run while others had the cores; Linux only, else None."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One recording, run once through one arrangement."""

    arrangement: Arrangement
    rows: tuple[Row, ...]
    offered: int
    dropped: int
    """Frames that a newer one replaced before they were read."""
    spent: Spent
    received: Received
    extra_packets: int
    """Packets among them without a frame: our loop's last one."""
    hands_ms: tuple[float, ...]
    """How much older than the frame its hands were, the median of each second; empty where each
    frame waits for its own."""


class Parts(Protocol):
    """The parts of the service as it really runs; the app provides them."""

    def tracker(self) -> TrackerThread:
        """The hand tracker in its thread."""

    def state(self) -> State:
        """The sensing before its first frame."""

    def publisher(self, watch: Stopwatch, port: int) -> tuple[Publishes, Callable[[], None]]:
        """A publisher to a port of this machine, with laps around it; and how to close it."""

    def sequential(self, watch: Stopwatch) -> tuple[Sequential, Callable[[], None]]:
        """The paper's order with a hand tracker of its own; and how to close it."""


class _TimedPublisher:
    """A publisher that records when the sensing is done, and when a frame's packet is sent."""

    def __init__(self, publisher: Publishes, watch: Stopwatch) -> None:
        self._publisher = publisher
        self._watch = watch
        self.hands_ms: list[float] = []

    def frame(self, frame: TouchFrame) -> None:
        self._watch.lap("sense")
        self._publisher.frame(frame)
        self._watch.end(frame)

    def scene(self, state: State) -> None:
        self._publisher.scene(state)

    def health(self, health: Health) -> None:
        if health.tracker_ms >= 0.0:
            self.hands_ms.append(health.tracker_ms)
        self._publisher.health(health)


def run(
    recording: LatencyRecording, parts: Parts, listener: Listener, rounds: int
) -> Iterator[Block]:
    """Run the recording twice per round, once through each; the first one alternates."""
    for number in range(rounds):
        order: tuple[Arrangement, ...] = ("ours", "sequential")
        for arrangement in order if number % 2 == 0 else order[::-1]:
            yield _block(arrangement, recording, parts, listener)


def _block(
    arrangement: Arrangement, recording: LatencyRecording, parts: Parts, listener: Listener
) -> Block:
    watch = Stopwatch()
    source = PacedSource(recording.frames, recording.camera, recording.kind, watch)
    publisher, close = parts.publisher(watch, listener.port)
    timed = _TimedPublisher(publisher, watch)
    listener.received()
    try:
        if arrangement == "ours":
            spent = _ours(source, timed, parts)
        else:
            spent = _sequential(source, publisher, watch, parts)
    finally:
        close()
    return Block(
        arrangement,
        tuple(watch.rows),
        len(recording.frames),
        source.dropped,
        spent,
        listener.received(),
        watch.extra_packets,
        tuple(timed.hands_ms),
    )


def _ours(source: PacedSource, timed: _TimedPublisher, parts: Parts) -> Spent:
    """Run the service's own loop, with the tracker in parallel."""
    tracker = parts.tracker()
    try:
        while tracker.state == "starting":
            time.sleep(STARTING_S)
        loop = LiveLoop(source, _never, tracker, parts.state(), timed)
        return _spent(loop.run)
    finally:
        tracker.close()


def _sequential(source: PacedSource, publisher: Publishes, watch: Stopwatch, parts: Parts) -> Spent:
    sequential, close = parts.sequential(watch)
    try:
        return _spent(lambda: sequential.run(source, publisher.frame))
    finally:
        close()


def _spent(act: Callable[[], None]) -> Spent:
    """Run `act`, and measure its cost."""
    cpu_s, path_s, wait_ms = time.process_time(), time.thread_time(), _core_wait_ms()
    act()
    waited_ms = _core_wait_ms()
    return Spent(
        1000.0 * (time.process_time() - cpu_s),
        1000.0 * (time.thread_time() - path_s),
        None if wait_ms is None or waited_ms is None else waited_ms - wait_ms,
    )


def _core_wait_ms() -> float | None:
    """How long this thread has waited for a core so far, as Linux counts it."""
    if not SCHEDSTAT.is_file():
        return None
    _, waited_ns, _ = SCHEDSTAT.read_text().split()
    return int(waited_ns) / 1e6


def _never() -> Source:
    raise AssertionError("a source in memory never reconnects")
