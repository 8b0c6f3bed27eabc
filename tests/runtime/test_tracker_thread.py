"""The hand tracker's thread gives way to the frames' thread."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest

from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.values import Frame, Tracked

FOUND_S = 10.0


class Recorder:
    """A tracker that records how its thread, and one that it started, are scheduled."""

    def __init__(self) -> None:
        self.policies = [os.sched_getscheduler(0)]
        child = threading.Thread(target=lambda: self.policies.append(os.sched_getscheduler(0)))
        child.start()
        child.join()

    def detect(self, frame: Frame) -> Tracked:
        return Tracked(frame.time_us, ())

    def close(self) -> None:
        pass


@contextmanager
def started() -> Iterator[Recorder]:
    """Yield the tracker that was built in the tracker thread."""
    recorders: list[Recorder] = []
    ready = threading.Event()

    def make() -> Recorder:
        recorders.append(Recorder())
        ready.set()
        return recorders[0]

    with closing(TrackerThread(make)):
        assert ready.wait(FOUND_S)
        yield recorders[0]


@pytest.mark.skipif(not hasattr(os, "SCHED_BATCH"), reason="only Linux has batch threads")
def test_the_tracker_and_what_it_starts_wait_for_a_free_core() -> None:
    ours = os.sched_getscheduler(0)
    with started() as recorder:
        assert recorder.policies == [os.SCHED_BATCH, os.SCHED_BATCH]
    assert os.sched_getscheduler(0) == ours != os.SCHED_BATCH


@pytest.mark.skipif(not hasattr(os, "SCHED_BATCH"), reason="only Linux has batch threads")
def test_hands_are_tracked_even_if_scheduling_is_forbidden(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with started() as recorder:
        assert recorder.policies == [os.sched_getscheduler(0)] * 2
