"""The live loop: a capture comes in, its packet leaves, nothing in between waits.

It owns the service's clock. Whatever a camera does, clients hear at least once a second. An
unexpected error costs the frame in which it happens: it is logged and counted, all pointers are
released, and the next frame is sensed.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Protocol

from halo_service.errors import UserError
from halo_service.runtime.checks import judge
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.health import Health, Pulse
from halo_service.runtime.method import OURS, Method
from halo_service.runtime.tracker_thread import TrackerState, TrackerThread
from halo_service.sensing import State
from halo_service.sources import EndOfSource, Source, SourceLost
from halo_service.values import BadFrame, Frame, TouchFrame

log = logging.getLogger(__name__)

READ_S = 0.25
"""Longest wait for a capture, so that the loop can beat, stop and reconnect."""
KEEP_ALIVE_S = 0.6
"""Silence after which an empty frame is sent; with `READ_S` that makes 1 Hz or more."""
SCENE_S, HEALTH_S = 0.4, 0.9
"""How often scene and health are told; with `READ_S` that makes 2 Hz and 1 Hz nearly or more."""
SILENCE_S = 5.0
"""A camera that gave nothing for so long is as good as unplugged."""
RECONNECT_S = 0.4
"""Pause between two tries to open a camera that was lost."""
FRAME_S = 0.0105
"""Least time between two frames: the frame counter of a restarted service starts at Unix time in
steps of 10 ms, and must be ahead of what was sent before, however fast a recording is played."""
BEHIND_US = 100_000
"""What is told in a silence is dated this much back, so that the next capture is never earlier."""


class Publisher(Protocol):
    """Tells clients; the app makes it out of the outputs."""

    def frame(self, told: TouchFrame) -> None:
        """Send one frame."""

    def scene(self, state: State) -> None:
        """Send what late joiners must know."""

    def health(self, vitals: Health) -> None:
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
        tracker: TrackerThread | None,
        state: State,
        publisher: Publisher,
        obey: Obey = _hear_nothing,
        watch: Callable[[Frame], None] = _watch_nothing,
        method: Method[State] = OURS,
    ) -> None:
        """`reopen` opens the same source again after it was lost; `tracker`: None where nobody
        needs hands; `obey` takes clients' orders; `watch` is shown each good frame after its
        packet has left; `method` senses each frame."""
        self._source: Source | None = source
        self._reopen = reopen
        self._tracker = tracker
        self._state = state
        self._publisher = publisher
        self._obey = obey
        self._watch = watch
        self._method = method
        self._errors = ErrorLog()
        self._stopped = threading.Event()
        self._pulse = Pulse()
        self._last_us: int | None = None
        self._bad_in_a_row = 0
        self._heard_s = time.monotonic()
        self._sent_s = self._scene_s = self._health_s = float("-inf")

    def stop(self) -> None:
        """Let `run` end soon; from any thread or signal handler."""
        self._stopped.set()

    def run(self) -> None:
        """Sense and publish until stopped. Raises `UserError` when it cannot go on."""
        try:
            while not self._stopped.is_set():
                with self._errors.guard("status"):
                    self._beat()
                if self._tracker is not None and self._tracker.failure is not None:
                    raise self._tracker.failure
                with self._errors.guard("control"):
                    self._state = self._obey(self._state, self._source)
                self._turn()
        except EndOfSource:
            self._pulse.camera = "ended"
        finally:
            self._release(self._silent_us())
            with self._errors.guard("status"):
                self._publisher.health(self._vitals())
            if self._source is not None:
                self._source.close()

    def _turn(self) -> None:
        """One capture, or one wait for it."""
        if self._source is None:
            self._reconnect()
            return
        try:
            capture = self._read(self._source)
            if capture is None and time.monotonic() - self._heard_s > SILENCE_S:
                raise SourceLost(f"camera: nothing came for {SILENCE_S:.0f} s; opening it anew")
        except SourceLost as error:
            log.warning("%s", error)
            self._lose(self._source)
            return
        if capture is not None:
            self._take(capture, self._source.camera.fps)
        elif time.monotonic() - self._sent_s > KEEP_ALIVE_S:
            self._release(self._silent_us())

    def _take(self, capture: Frame | BadFrame, fps: float) -> None:
        received_s = self._heard_s = time.monotonic()
        judged = judge(capture, self._last_us, fps)
        self._last_us = capture.time_us
        self._pulse.camera = "running"
        self._pulse.drops += judged.missed
        if isinstance(capture, BadFrame) or judged.fault is not None:
            self._skip(judged.fault or "bad", capture.time_us)
            return
        tracked = None if self._tracker is None else self._tracker.newest
        try:
            touch_frame, self._state = self._method.step(self._state, capture, tracked)
            self._publish(touch_frame)
        except Exception as error:
            self._skip(self._errors.report("sensing", error), capture.time_us)
        else:
            self._good_again()
            age_us = capture.time_us - tracked.time_us if tracked else None
            self._pulse.sent(received_s, self._sent_s, age_us)
        if self._tracker is not None:
            self._tracker.offer(capture)  # it needs a core too; by now no packet waits for one
        with self._errors.guard("profile"):
            self._watch(capture)

    def _read(self, source: Source) -> Frame | BadFrame | None:
        """Read the next capture. An unexpected error counts as a bad frame and as silence."""
        try:
            return source.read(READ_S)
        except (EndOfSource, UserError):
            raise
        except Exception as error:
            self._skip(self._errors.report("source", error), self._silent_us())
            return None

    def _skip(self, fault: str, time_us: int) -> None:
        """Count a frame that could not be sensed, and release all pointers."""
        self._pulse.bad_frames += 1
        if self._bad_in_a_row == 0:  # not each bad one: a broken camera must not fill a disk
            log.warning("frame: %s; all pointers are released", fault)
        self._bad_in_a_row += 1
        self._release(time_us)

    def _good_again(self) -> None:
        if self._bad_in_a_row:
            log.warning("frame: good again after %d that could not be sensed", self._bad_in_a_row)
            self._bad_in_a_row = 0

    def _release(self, time_us: int) -> None:
        """Send an empty frame, so that no pointer stays behind at a client."""
        with self._errors.guard("release"):
            touch_frame, self._state = self._method.clear(self._state, time_us)
            self._publish(touch_frame)

    def _publish(self, told: TouchFrame) -> None:
        self._stopped.wait(self._sent_s + FRAME_S - time.monotonic())
        try:
            self._publisher.frame(told)
        finally:  # an output that always fails must not let the loop spin
            self._sent_s = time.monotonic()

    def _silent_us(self) -> int:
        """Return the source's time while it says nothing: its last, and most of what has passed."""
        if self._last_us is None:
            return time.time_ns() // 1000
        passed_us = round((time.monotonic() - self._heard_s) * 1e6)
        return self._last_us + max(passed_us - BEHIND_US, 0)

    def _beat(self) -> None:
        now_s = time.monotonic()
        if now_s - self._scene_s >= SCENE_S:
            self._scene_s = now_s
            self._publisher.scene(self._state)
        if now_s - self._health_s >= HEALTH_S:
            self._health_s = now_s
            self._publisher.health(self._vitals())

    def _vitals(self) -> Health:
        seeing = self._tracker is not None and self._pulse.camera == "running"
        idle: TrackerState = "off" if self._tracker is None else "searching"
        state = self._tracker.state if self._tracker is not None and seeing else idle
        return self._pulse.vitals(time.monotonic(), state)

    def _lose(self, source: Source) -> None:
        self._pulse.camera = "lost"
        self._source = None
        with self._errors.guard("source"):
            source.close()
        self._release(self._silent_us())
        with self._errors.guard("status"):
            self._publisher.health(self._vitals())

    def _reconnect(self) -> None:
        self._release(self._silent_us())
        self._stopped.wait(RECONNECT_S)
        try:
            self._source = self._reopen()
        except UserError as error:
            log.debug("camera: not back yet: %s", error)
            return
        except Exception as error:
            self._errors.report("source", error)
            return
        self._last_us = None
        self._heard_s = time.monotonic()
        self._release(time.time_ns() // 1000)
        log.warning("camera: found again")
