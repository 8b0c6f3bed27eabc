"""The hand tracker's thread gives way to the frames' thread."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

import numpy as np
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

    looks = 0

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


class Hanging:
    """A tracker that hangs at some of its frames until it is released."""

    made = 0

    def __init__(self, at: set[int], released: threading.Event) -> None:
        Hanging.made += 1
        self.at, self.released = at, released

    looks = 0

    def detect(self, frame: Frame) -> Tracked:
        if frame.time_us in self.at:
            self.released.wait()
        return Tracked(frame.time_us, ())

    def close(self) -> None:
        pass


def offer_until(tracker: TrackerThread, time_us: int, done: Callable[[], bool]) -> None:
    until = time.monotonic() + FOUND_S
    empty = np.zeros((2, 2), np.uint16)
    while not done():
        tracker.offer(Frame(time_us, empty, empty))
        assert time.monotonic() < until
        time.sleep(0.005)


def test_a_tracker_that_hangs_is_replaced_and_reported(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("halo_service.runtime.tracker_thread.HANGS_S", 0.1)
    Hanging.made = 0
    released = threading.Event()
    tracker = TrackerThread(lambda: Hanging({2}, released))
    try:
        offer_until(tracker, 1, lambda: tracker.newest is not None)
        offer_until(tracker, 2, lambda: tracker.state == "failed")
        assert tracker.newest is None  # hands of long ago are no hands
        offer_until(tracker, 3, lambda: tracker.newest is not None)
        assert tracker.state == "searching"
        assert Hanging.made == 2
        released.set()  # the old thread goes on and must change nothing
        offer_until(tracker, 4, lambda: tracker.newest is not None and tracker.newest.time_us == 4)
        assert tracker.failure is None
        assert sum("no answer" in each.getMessage() for each in caplog.records) == 1
    finally:
        released.set()
        tracker.close()


def test_a_tracker_that_always_hangs_ends_the_service(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("halo_service.runtime.tracker_thread.HANGS_S", 0.02)
    released = threading.Event()
    tracker = TrackerThread(lambda: Hanging({1}, released))
    try:
        offer_until(tracker, 1, lambda: tracker.failure is not None)
        assert "hung 6 times in a row" in str(tracker.failure)
    finally:
        released.set()
        tracker.close()
