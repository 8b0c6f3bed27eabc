"""One run: the two arrangements by turns, over the same frames, so that noise hits both alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

from halo_service.evaluation.latency.drawn import Take
from halo_service.evaluation.latency.handed import Player
from halo_service.evaluation.latency.listener import Heard, Listener
from halo_service.evaluation.latency.sequential import Sequential
from halo_service.evaluation.latency.stopwatch import Row, Stopwatch
from halo_service.runtime.beside import TrackerBeside
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.live import Publisher as Publishes
from halo_service.runtime.vitals import Vitals
from halo_service.sensing import State
from halo_service.sources import Source
from halo_service.values import TouchFrame

Arrangement = Literal["ours", "sequential"]
STARTING_S = 0.05
"""How often a starting tracker is asked whether it is there."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One take, played once through one arrangement."""

    arrangement: Arrangement
    rows: tuple[Row, ...]
    offered: int
    dropped: int
    """Frames that a newer one replaced before they were taken."""
    cpu_ms: float
    """Of all threads, from the first frame to the last."""
    path_cpu_ms: float
    """Of the thread that takes frames and sends packets."""
    heard: Heard
    unasked: int
    """Packets among them that told of no frame: our loop's farewell."""


class Parts(Protocol):
    """What the app hands in: the parts of the service as it really runs."""

    def tracker(self) -> TrackerBeside:
        """The hand tracker in its thread."""

    def state(self) -> State:
        """The sensing before its first frame."""

    def publisher(self, watch: Stopwatch, port: int) -> tuple[Publishes, Callable[[], None]]:
        """What sends to a port of this machine, with laps around it; and how to close it."""

    def sequential(self) -> tuple[Sequential, Callable[[], None]]:
        """The paper's order with a hand tracker of its own; and how to close it."""


class _Told:
    """A publisher that says when the sensing is done, and when a frame's packet has gone."""

    def __init__(self, publisher: Publishes, watch: Stopwatch) -> None:
        self._publisher = publisher
        self._watch = watch

    def frame(self, told: TouchFrame) -> None:
        self._watch.lap("sense")
        self._publisher.frame(told)
        self._watch.end(told)

    def scene(self, state: State) -> None:
        self._publisher.scene(state)

    def health(self, vitals: Vitals) -> None:
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
    play = _ours if arrangement == "ours" else _sequential
    listener.heard()
    try:
        cpu_s, path_cpu_s = play(player, publisher, watch, parts)
    finally:
        close()
    return Block(
        arrangement,
        tuple(watch.rows),
        len(take.captures),
        player.dropped,
        1000.0 * cpu_s,
        1000.0 * path_cpu_s,
        listener.heard(),
        watch.unasked,
    )


def _ours(
    player: Player, publisher: Publishes, watch: Stopwatch, parts: Parts
) -> tuple[float, float]:
    """Run the service's own loop, with the tracker beside it."""
    tracker = parts.tracker()
    try:
        while tracker.state == "starting":
            time.sleep(STARTING_S)
        loop = LiveLoop(player, _never, tracker, parts.state(), _Told(publisher, watch))
        return _cpu_s(loop.run)
    finally:
        tracker.close()


def _sequential(
    player: Player, publisher: Publishes, watch: Stopwatch, parts: Parts
) -> tuple[float, float]:
    sequential, close = parts.sequential()
    try:
        return _cpu_s(lambda: sequential.run(player, publisher.frame, watch))
    finally:
        close()


def _cpu_s(act: Callable[[], None]) -> tuple[float, float]:
    """CPU time of all threads and of this one while it acts, s."""
    all_s, this_s = time.process_time(), time.thread_time()
    act()
    return time.process_time() - all_s, time.thread_time() - this_s


def _never() -> Source:
    raise AssertionError("what is held in memory is never lost")
