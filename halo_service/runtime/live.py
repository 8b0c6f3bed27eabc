"""The live loop: a capture comes in, its packet leaves, nothing in between waits.

It owns the service's clock. Whatever a camera does, clients hear at least once a second.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Protocol

from halo_service.errors import UserError
from halo_service.runtime.beside import TrackerBeside
from halo_service.runtime.checks import judge
from halo_service.runtime.vitals import Pulse, Vitals
from halo_service.sensing import State, clear, step
from halo_service.sources import EndOfSource, Source, SourceLost
from halo_service.values import BadFrame, Frame, TouchFrame

log = logging.getLogger(__name__)

READ_S = 0.25
"""Longest wait for a capture, so that the loop can beat, stop and reconnect."""
KEEP_ALIVE_S = 0.75
"""Silence after which an empty frame is sent; with `READ_S` that makes 1 Hz or more."""
SCENE_S, HEALTH_S = 0.5, 1.0
"""How often scene and health are told."""
RECONNECT_S = 1.0
"""Pause between two tries to open a camera that was lost."""


class Publisher(Protocol):
    """Tells clients; the app makes it out of the outputs."""

    def frame(self, told: TouchFrame) -> None:
        """Send one frame."""

    def scene(self, state: State) -> None:
        """Send what late joiners must know."""

    def health(self, vitals: Vitals) -> None:
        """Send how the service fares."""


Obey = Callable[[State, Source | None], State]
"""Takes what clients have ordered since the last frame, and returns the state that it leaves."""


def _hear_nothing(state: State, source: Source | None) -> State:
    return state


def _watch_nothing(frame: Frame) -> None:
    """Nobody but the sensing looks at frames."""


class LiveLoop:
    """Runs until it is stopped or its recording ends; closes the source that it was given."""

    def __init__(
        self,
        source: Source,
        reopen: Callable[[], Source],
        tracker: TrackerBeside,
        state: State,
        publisher: Publisher,
        obey: Obey = _hear_nothing,
        watch: Callable[[Frame], None] = _watch_nothing,
    ) -> None:
        """`reopen` opens the same source again after it was lost; `obey` takes clients' orders;
        `watch` is shown each good frame after its packet has left."""
        self._source: Source | None = source
        self._reopen = reopen
        self._tracker = tracker
        self._state = state
        self._publisher = publisher
        self._obey = obey
        self._watch = watch
        self._stopped = threading.Event()
        self._pulse = Pulse()
        self._last_us: int | None = None
        self._last_s = self._scene_s = self._health_s = float("-inf")

    def stop(self) -> None:
        """Let `run` end soon; from any thread or signal handler."""
        self._stopped.set()

    def run(self) -> None:
        """Sense and publish until stopped. Raises `UserError` when it cannot go on."""
        try:
            while not self._stopped.is_set():
                self._beat()
                if self._tracker.failure is not None:
                    raise self._tracker.failure
                self._state = self._obey(self._state, self._source)
                self._turn()
        except EndOfSource:
            self._pulse.camera = "ended"
        finally:
            self._let_go()
            self._publisher.health(self._pulse.vitals(time.monotonic(), self._tracker.state))
            if self._source is not None:
                self._source.close()

    def _turn(self) -> None:
        """One capture, or one wait for it."""
        if self._source is None:
            self._reconnect()
            return
        try:
            capture = self._source.read(READ_S)
        except SourceLost as error:
            log.warning("%s", error)
            self._lose(self._source)
            return
        if capture is not None:
            self._take(capture, self._source.camera.fps)
        elif time.monotonic() - self._last_s > KEEP_ALIVE_S:
            self._let_go()

    def _take(self, capture: Frame | BadFrame, fps: float) -> None:
        received_s = time.monotonic()
        judged = judge(capture, self._last_us, fps)
        self._last_us = capture.time_us
        self._pulse.camera = "running"
        self._pulse.drops += judged.missed
        if isinstance(capture, BadFrame) or judged.fault is not None:
            self._pulse.bad_frames += 1
            log.warning("frame: %s; all pointers were let go", judged.fault)
            self._let_go()
            return
        self._tracker.offer(capture)
        tracked = self._tracker.newest
        told, self._state = step(self._state, capture, tracked)
        self._publisher.frame(told)
        self._last_s = time.monotonic()
        age_us = capture.time_us - tracked.time_us if tracked else None
        self._pulse.sent(received_s, self._last_s, age_us)
        self._watch(capture)

    def _let_go(self) -> None:
        """Send an empty frame, so that nothing sticks on the other side."""
        told, self._state = clear(self._state, self._time_us())
        self._publisher.frame(told)
        self._last_s = time.monotonic()

    def _time_us(self) -> int:
        """Return the source's time now: its last, and what has passed since."""
        if self._last_us is None:
            return time.time_ns() // 1000
        passed_s = time.monotonic() - self._last_s
        return self._last_us + (round(passed_s * 1e6) if passed_s < float("inf") else 0)

    def _beat(self) -> None:
        now_s = time.monotonic()
        if now_s - self._scene_s >= SCENE_S:
            self._scene_s = now_s
            self._publisher.scene(self._state)
        if now_s - self._health_s >= HEALTH_S:
            self._health_s = now_s
            self._publisher.health(self._pulse.vitals(now_s, self._tracker.state))

    def _lose(self, source: Source) -> None:
        self._pulse.camera = "lost"
        self._source = None
        self._last_us = None
        source.close()
        self._let_go()

    def _reconnect(self) -> None:
        try:
            self._source = self._reopen()
            log.warning("camera: found again")
        except UserError as error:
            log.debug("camera: not back yet: %s", error)
            self._let_go()
            self._stopped.wait(RECONNECT_S)
