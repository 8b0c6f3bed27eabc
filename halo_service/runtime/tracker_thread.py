"""The hand tracker in a thread of its own: it looks at the newest frame and never delays one.

A frame that comes while it is busy replaces the one that waits. The sensing uses the hands that
it found last and moves them to the present frame.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Literal, Protocol

from halo_service.errors import UserError
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.latest import Latest
from halo_service.values import Frame, Tracked

WAKE_S = 0.2
"""How often the thread checks whether to end."""
AGAIN_S = 1.0
"""Pause before a tracker that failed is loaded again."""

TrackerState = Literal["off", "starting", "searching", "tracking", "failed"]


class Tracker(Protocol):
    """Finds hands in frames; stateful, slow, used from one thread."""

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
        self._ended = threading.Event()
        self._outdated = threading.Event()
        self.state: TrackerState = "starting"
        self.failure: UserError | None = None
        """Set if the tracker cannot be loaded at all; the service ends with this sentence."""
        self._thread = threading.Thread(target=self._run, name="hand tracker", daemon=True)
        self._thread.start()

    @property
    def newest(self) -> Tracked | None:
        """The hands that the tracker found last."""
        return self._tracked.peek()

    def offer(self, frame: Frame) -> None:
        """Offer a frame; the tracker looks at it when free, unless a newer one comes first."""
        self._frames.put(frame)

    def reload(self) -> None:
        """Make the tracker again, because what it is made from has changed."""
        self._outdated.set()

    def close(self) -> None:
        """End the thread after its current frame."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        _yield_the_core()
        errors = ErrorLog()
        worked = False
        while not self._ended.is_set():
            self._outdated.clear()
            try:
                tracker = self._make()
                worked = True
                try:
                    self._look_on(tracker)
                finally:
                    tracker.close()
            except Exception as error:
                self.state = "failed"
                if isinstance(error, UserError) and not worked:
                    self.failure = error
                    return
                # Once it worked, no error of the model ends the service: load it again.
                errors.report("hand tracker", error)
                self._tracked.clear()
                self._ended.wait(AGAIN_S)

    def _look_on(self, tracker: Tracker) -> None:
        self.state = "searching"
        while not self._ended.is_set() and not self._outdated.is_set():
            frame = self._frames.take(WAKE_S)
            if frame is None:
                continue
            tracked = tracker.detect(frame)
            self._tracked.put(tracked)
            self.state = "tracking" if tracked.hands else "searching"


def _yield_the_core() -> None:
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
