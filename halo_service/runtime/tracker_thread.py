"""The hand tracker in a thread of its own: it looks at the newest frame and never delays one.

A frame that comes while it is busy replaces the one that waits. The sensing uses the hands that
it found last and moves them to the present frame.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Literal, Protocol

from halo_service.errors import UserError
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.latest import Latest
from halo_service.values import Frame, Tracked

log = logging.getLogger(__name__)

WAKE_S = 0.2
"""How often the thread checks whether to end."""
AGAIN_S = 1.0
"""Pause before a tracker that failed is loaded again."""

HANGS_S = 3.0
"""A tracker that looks at one frame for so long hangs: usual is 0.02 s. Another one is started."""
MOST_HANGING = 5
"""A thread cannot be killed: after so many in a row the service ends, so that it starts anew."""

TrackerState = Literal["off", "starting", "searching", "tracking", "failed"]


class Tracker(Protocol):
    """Finds hands in frames; stateful, slow, used from one thread."""

    @property
    def looks(self) -> int:
        """How many images the model has got."""

    def detect(self, frame: Frame) -> Tracked:
        """Find the hands in one frame."""

    def close(self) -> None:
        """Free the model."""


class TrackerThread:
    """Runs a tracker in a thread of its own."""

    def __init__(self, make: Callable[[], Tracker]) -> None:
        """`make` is called in the thread: loading takes seconds, and frames must not wait."""
        self._make = make
        self._frames: Latest[Frame] = Latest()
        self._tracked: Latest[Tracked] = Latest()
        self._outdated = threading.Event()
        self.state: TrackerState = "starting"
        self.failure: UserError | None = None
        """Set if the tracker cannot be loaded at all; the service ends with this sentence."""
        self.looks = 0
        """How many images the model has got: fewer than frames, as depth confirms hands."""
        self._hanging = 0
        self._worker = self._started()

    @property
    def newest(self) -> Tracked | None:
        """The hands that the tracker found last."""
        return self._tracked.peek()

    def offer(self, frame: Frame) -> None:
        """Offer a frame; the tracker looks at it when free, unless a newer one comes first."""
        self._frames.put(frame)
        since_s = self._worker.busy_since_s
        if since_s is not None and time.monotonic() - since_s > HANGS_S:
            self._replace()

    def reload(self) -> None:
        """Make the tracker again, because what it is made from has changed."""
        self._outdated.set()

    def close(self) -> None:
        """End the thread after its current frame."""
        self._worker.ended.set()
        self._worker.thread.join(HANGS_S)

    def _started(self) -> _Worker:
        worker = _Worker(self._run)
        worker.thread.start()
        return worker

    def _replace(self) -> None:
        """Leave a thread that hangs to itself; it ends if it ever goes on."""
        self._worker.ended.set()
        self._frames.clear()  # the frame that it hangs at is not for the next one
        self._tracked.clear()
        self._hanging += 1
        self.state = "failed"
        if self._hanging > MOST_HANGING:
            self.failure = UserError(
                f"the hand tracker hung {self._hanging} times in a row; start the service again"
            )
            return
        log.error("hand tracker: no answer for %.0f s; another one is started", HANGS_S)
        self._worker = self._started()

    def _run(self, worker: _Worker) -> None:
        yield_the_core()
        errors = ErrorLog()
        worked = False
        while not worker.ended.is_set():
            self._outdated.clear()
            try:
                tracker = self._make()
                worked = True
                try:
                    self._look_on(tracker, worker)
                finally:
                    tracker.close()
            except Exception as error:
                worker.busy_since_s = None
                if worker.ended.is_set():
                    return
                self.state = "failed"
                if isinstance(error, UserError) and not worked:
                    self.failure = error
                    return
                # Once it worked, no error of the model ends the service: load it again.
                errors.report("hand tracker", error)
                self._tracked.clear()
                worker.ended.wait(AGAIN_S)

    def _look_on(self, tracker: Tracker, worker: _Worker) -> None:
        while not worker.ended.is_set() and not self._outdated.is_set():
            frame = self._frames.take(WAKE_S)
            if frame is None:
                if self.state == "starting":
                    self.state = "searching"
                continue
            worker.busy_since_s = time.monotonic()
            looks = tracker.looks
            tracked = tracker.detect(frame)
            worker.busy_since_s = None
            if worker.ended.is_set():
                return  # it hung, and another one works by now
            self._hanging = 0
            self.looks += tracker.looks - looks
            self._tracked.put(tracked)
            self.state = "tracking" if tracked.hands else "searching"


class _Worker:
    """One thread with a tracker of its own."""

    def __init__(self, run: Callable[[_Worker], None]) -> None:
        self.ended = threading.Event()
        self.busy_since_s: float | None = None
        """Since when it looks at one frame; None while it waits for one."""
        self.thread = threading.Thread(target=run, args=(self,), name="hand tracker", daemon=True)


def yield_the_core() -> None:
    """Keep this thread, and those that it starts, from pushing another one off a core.

    Only Linux can: a batch thread gets its full share, but when it wakes it waits until a core is
    free. The model's own threads wake many times an image. With two hands they took the core
    from the frames' thread, for a third of a frame's processing time.
    """
    batch = getattr(os, "SCHED_BATCH", None)
    if batch is None:
        return
    with suppress(OSError):  # a sandbox may forbid it: the frames wait a little, nothing breaks
        os.sched_setscheduler(0, batch, os.sched_param(0))  # 0: of the calling thread
