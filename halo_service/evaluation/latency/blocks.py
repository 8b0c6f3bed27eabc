"""One run: the two arrangements by turns, over the same frames, so that noise hits both alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

from halo_service.evaluation.latency.listener import Heard, Listener
from halo_service.evaluation.latency.raw_frames import Player
from halo_service.evaluation.latency.sequential import Sequential
from halo_service.evaluation.latency.simulate import Take
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
"""How often a starting tracker is asked whether it is there."""
SCHEDSTAT = Path("/proc/thread-self/schedstat")
"""Linux: nanoseconds on a core, nanoseconds of waiting for one, and how often."""


@dataclass(frozen=True, slots=True)
class Spent:
    """What playing a take cost, from its first frame to its last."""

    cpu_ms: float
    """Of all threads."""
    path_cpu_ms: float
    """Of the thread that takes frames and sends packets."""
    core_wait_ms: float | None
    """How long that thread was ready to run while others had the cores; None where the system
    does not say (Linux does)."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One take, played once through one arrangement."""

    arrangement: Arrangement
    rows: tuple[Row, ...]
    offered: int
    dropped: int
    """Frames that a newer one replaced before they were taken."""
    spent: Spent
    heard: Heard
    unasked: int
    """Packets among them that told of no frame: our loop's farewell."""
    hands_ms: tuple[float, ...]
    """How much older than its frame the hands were that it was sensed with, the median of each
    second; empty where each frame waits for its own."""


class Parts(Protocol):
    """What the app hands in: the parts of the service as it really runs."""

    def tracker(self) -> TrackerThread:
        """The hand tracker in its thread."""

    def state(self) -> State:
        """The sensing before its first frame."""

    def publisher(self, watch: Stopwatch, port: int) -> tuple[Publishes, Callable[[], None]]:
        """What sends to a port of this machine, with laps around it; and how to close it."""

    def sequential(self, watch: Stopwatch) -> tuple[Sequential, Callable[[], None]]:
        """The paper's order with a hand tracker of its own; and how to close it."""


class _Told:
    """A publisher that says when the sensing is done, and when a frame's packet has gone."""

    def __init__(self, publisher: Publishes, watch: Stopwatch) -> None:
        self._publisher = publisher
        self._watch = watch
        self.hands_ms: list[float] = []

    def frame(self, told: TouchFrame) -> None:
        self._watch.lap("sense")
        self._publisher.frame(told)
        self._watch.end(told)

    def scene(self, state: State) -> None:
        self._publisher.scene(state)

    def health(self, vitals: Health) -> None:
        if vitals.tracker_ms >= 0.0:
            self.hands_ms.append(vitals.tracker_ms)
        self._publisher.health(vitals)


def run(take: Take, parts: Parts, listener: Listener, rounds: int) -> Iterator[Block]:
    """Play the take twice a round, once through each; every other round the other goes first."""
    for number in range(rounds):
        order: tuple[Arrangement, ...] = ("ours", "sequential")
        for arrangement in order if number % 2 == 0 else order[::-1]:
            yield _block(arrangement, take, parts, listener)


def _block(arrangement: Arrangement, take: Take, parts: Parts, listener: Listener) -> Block:
    watch = Stopwatch()
    player = Player(take.captures, take.camera, take.kind, watch)
    publisher, close = parts.publisher(watch, listener.port)
    told = _Told(publisher, watch)
    listener.heard()
    try:
        if arrangement == "ours":
            spent = _ours(player, told, parts)
        else:
            spent = _sequential(player, publisher, watch, parts)
    finally:
        close()
    return Block(
        arrangement,
        tuple(watch.rows),
        len(take.captures),
        player.dropped,
        spent,
        listener.heard(),
        watch.unasked,
        tuple(told.hands_ms),
    )


def _ours(player: Player, told: _Told, parts: Parts) -> Spent:
    """Run the service's own loop, with the tracker beside it."""
    tracker = parts.tracker()
    try:
        while tracker.state == "starting":
            time.sleep(STARTING_S)
        loop = LiveLoop(player, _never, tracker, parts.state(), told)
        return _spent(loop.run)
    finally:
        tracker.close()


def _sequential(player: Player, publisher: Publishes, watch: Stopwatch, parts: Parts) -> Spent:
    sequential, close = parts.sequential(watch)
    try:
        return _spent(lambda: sequential.run(player, publisher.frame))
    finally:
        close()


def _spent(act: Callable[[], None]) -> Spent:
    """Act, and say what it cost."""
    cpu_s, path_s, wait_ms = time.process_time(), time.thread_time(), _core_wait_ms()
    act()
    waited_ms = _core_wait_ms()
    return Spent(
        1000.0 * (time.process_time() - cpu_s),
        1000.0 * (time.thread_time() - path_s),
        None if wait_ms is None or waited_ms is None else waited_ms - wait_ms,
    )


def _core_wait_ms() -> float | None:
    """How long this thread has waited for a core in its life, as Linux counts it."""
    if not SCHEDSTAT.is_file():
        return None
    _, waited_ns, _ = SCHEDSTAT.read_text().split()
    return int(waited_ns) / 1e6


def _never() -> Source:
    raise AssertionError("what is held in memory is never lost")
