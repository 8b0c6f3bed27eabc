"""The live loop: a capture comes in, its packet leaves, nothing in between waits.

It owns the service's clock. Clients receive a frame at least once a second, whatever the camera
does. An unexpected error costs the frame in which it happens: it is logged and counted, all
pointers are released, and the next frame is sensed.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Protocol

from halo_service.errors import UserError
from halo_service.host_clock import CLOCK
from halo_service.runtime.checks import check_capture
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.health import Health, HealthCounter, SlowWatch
from halo_service.runtime.load import LEVELS, LOOK_US, LoadWatch
from halo_service.runtime.memory import MemoryWatch
from halo_service.runtime.method import OURS, Method
from halo_service.runtime.tracker_thread import TrackerState, TrackerThread
from halo_service.sensing import State
from halo_service.sources import EndOfSource, Source, SourceLost
from halo_service.values import BadFrame, Frame, TouchFrame

log = logging.getLogger(__name__)

READ_S = 0.25
"""Longest wait for a capture, so that the loop can report, stop and reconnect."""
KEEP_ALIVE_S = 0.6
"""Silence after which an empty frame is sent; with `READ_S` that makes 1 Hz or more."""
SCENE_S, HEALTH_S = 0.4, 0.9
"""How often scene and health are sent; with `READ_S` that makes 2 Hz and 1 Hz nearly or more."""
SILENCE_S = 5.0
"""A camera without a capture for so long counts as unplugged."""
START_S = 60.0
"""The same until its first capture: on a busy machine a camera starts slowly, and one that is
opened again and again never does."""
RECONNECT_S = 0.4
"""Pause between two tries to open a camera that was lost."""
FRAME_S = 0.0105
"""Least time between two frames: the frame counter of a restarted service starts at Unix time in
steps of 10 ms, and must be ahead of what was sent before, however fast a recording runs."""
BEHIND_US = 100_000
"""Empty frames in a silence are dated back by this, so that the next capture is never earlier."""


class Publisher(Protocol):
    """Sends to clients; the app builds it from the outputs."""

    def frame(self, touch_frame: TouchFrame) -> None:
        """Send one frame."""

    def scene(self, state: State) -> None:
        """Send what a client that joins late needs."""

    def health(self, health: Health) -> None:
        """Send the state of the service."""


Control = Callable[[State, Source | None], State]
"""Handles the requests that clients sent since the last frame; returns the new state."""


def _no_requests(state: State, source: Source | None) -> State:
    return state


def _no_watcher(frame: Frame) -> None:
    """The default for `watch`."""


class LiveLoop:
    """Runs until it is stopped or its recording ends; then closes its source."""

    def __init__(
        self,
        source: Source,
        reopen: Callable[[], Source],
        tracker: TrackerThread | None,
        state: State,
        publisher: Publisher,
        control: Control = _no_requests,
        watch: Callable[[Frame], None] = _no_watcher,
        method: Method[State] = OURS,
        paused: threading.Event | None = None,
    ) -> None:
        """`reopen` opens the same source again after it was lost; `tracker`: None if no hands are
        needed; `control` handles clients' requests; `watch` gets each frame after its packet has
        left; `method` senses each frame; while `paused` is set, frames have no pointers."""
        self._source: Source | None = source
        self._reopen = reopen
        self._tracker = tracker
        self._state = state
        self._publisher = publisher
        self._control = control
        self._watch = watch
        self._method = method
        self._paused = paused or threading.Event()
        self._errors = ErrorLog()
        self._stopped = threading.Event()
        self._counter = HealthCounter()
        self._slow = SlowWatch()
        self._memory = MemoryWatch()
        self._last_us: int | None = None
        self._bad_in_a_row = 0
        self._load = LoadWatch()
        self._offered_us = 0
        self._received_s = self._asked_s = time.monotonic()
        self._sent_s = self._scene_s = self._health_s = float("-inf")

    def stop(self) -> None:
        """End `run` soon; from any thread or signal handler."""
        self._stopped.set()

    def run(self) -> None:
        """Sense and publish until stopped. Raises `UserError` if it cannot continue."""
        try:
            while not self._stopped.is_set():
                with self._errors.guard("status"):
                    self._report()
                if self._tracker is not None and self._tracker.failure is not None:
                    raise self._tracker.failure
                with self._errors.guard("control"):
                    self._state = self._control(self._state, self._source)
                self._read_one()
        except EndOfSource:
            self._counter.camera = "ended"
        finally:
            self._release(self._silent_us())
            with self._errors.guard("status"):
                self._publisher.health(self._health())
            if self._source is not None:
                self._source.close()

    def _read_one(self) -> None:
        """Process one capture, or one wait for it."""
        if self._source is None:
            self._reconnect()
            return
        try:
            capture = self._read(self._source)
            silence_s = SILENCE_S if self._last_us is not None else START_S
            if capture is None and time.monotonic() - self._received_s > silence_s:
                raise SourceLost(f"camera: no capture for {silence_s:.0f} s; opening it again")
        except SourceLost as error:
            log.warning("%s", error)
            self._lose(self._source)
            return
        if capture is not None:
            self._process(capture, self._source.camera.fps)
        elif time.monotonic() - self._sent_s > KEEP_ALIVE_S:
            self._release(self._silent_us())

    def _process(self, capture: Frame | BadFrame, fps: float) -> None:
        received_s = self._received_s = time.monotonic()
        check = check_capture(capture, self._last_us, fps)
        self._last_us = capture.time_us
        self._counter.camera = "running"
        self._counter.drops += check.missed
        if isinstance(capture, BadFrame) or check.fault is not None:
            self._skip(check.fault or "bad", capture.time_us)
            return
        if self._paused.is_set():
            self._release(capture.time_us)
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
            looks = self._tracker.looks if self._tracker is not None else 0
            self._counter.sent(received_s, self._sent_s, age_us, looks)
            self._watch_load(received_s, check.missed, fps)
        if self._tracker is not None and self._is_offered(capture.time_us):
            self._tracker.offer(capture)  # it needs a core too; by now no packet waits for one
        with self._errors.guard("profile"):
            self._watch(capture)

    def _watch_load(self, received_s: float, missed: int, fps: float) -> None:
        spent_s = self._sent_s - received_s
        waited_s = received_s - self._asked_s
        if fps > 0.0 and self._load.see(waited_s, spent_s, missed, 1.0 / fps):
            log.info("load: level %d, %s", self._load.level, LEVELS[self._load.level])

    def _is_offered(self, time_us: int) -> bool:
        """Return whether the hand tracker gets a frame: under load it gets fewer."""
        if 0 <= time_us - self._offered_us < LOOK_US[self._load.level]:
            return False
        self._offered_us = time_us
        return True

    def _read(self, source: Source) -> Frame | BadFrame | None:
        """Read the next capture. An unexpected error counts as a bad frame and as silence."""
        self._asked_s = time.monotonic()
        try:
            return source.read(READ_S)
        except (EndOfSource, UserError):
            raise
        except Exception as error:
            self._skip(self._errors.report("source", error), self._silent_us())
            return None

    def _skip(self, fault: str, time_us: int) -> None:
        """Count a frame that could not be sensed, and release all pointers."""
        self._counter.bad_frames += 1
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

    def _publish(self, touch_frame: TouchFrame) -> None:
        self._stopped.wait(self._sent_s + FRAME_S - time.monotonic())
        try:
            self._publisher.frame(touch_frame)
        finally:  # an output that always fails must not let the loop spin
            self._sent_s = time.monotonic()

    def _silent_us(self) -> int:
        """Return the source's time while it is silent: its last, plus most of the time since."""
        if self._last_us is None:
            return CLOCK.unix_us()
        passed_us = round((time.monotonic() - self._received_s) * 1e6)
        return self._last_us + max(passed_us - BEHIND_US, 0)

    def _report(self) -> None:
        now_s = time.monotonic()
        if now_s - self._scene_s >= SCENE_S:
            self._scene_s = now_s
            self._publisher.scene(self._state)
        if now_s - self._health_s >= HEALTH_S:
            self._health_s = now_s
            health = self._health()
            self._warn_if_slow(health)
            self._free_if_it_leaks(health.memory_mb)
            self._publisher.health(health)

    def _warn_if_slow(self, health: Health) -> None:
        warning = self._slow.see(health.fps, self._source.camera.fps) if self._source else ""
        if warning:
            log.warning("%s", warning)

    def _free_if_it_leaks(self, used_mb: int) -> None:
        """Load the hand model again, which has most of the memory."""
        if self._tracker is not None and self._memory.leaks(time.monotonic(), used_mb):
            log.error("memory: it grew to %d MB; the hand model is loaded again", used_mb)
            self._tracker.reload()

    def _health(self) -> Health:
        off = self._tracker is None or self._paused.is_set()
        running = not off and self._counter.camera == "running"
        idle: TrackerState = "off" if off else "searching"
        state = self._tracker.state if self._tracker is not None and running else idle
        return self._counter.health(time.monotonic(), state, self._load.level)

    def _lose(self, source: Source) -> None:
        self._counter.camera = "lost"
        self._source = None
        with self._errors.guard("source"):
            source.close()
        self._release(self._silent_us())
        with self._errors.guard("status"):
            self._publisher.health(self._health())

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
        self._received_s = time.monotonic()
        self._release(CLOCK.unix_us())
        log.warning("camera: found again")
