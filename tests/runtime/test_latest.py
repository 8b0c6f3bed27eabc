"""The one hand-off between threads."""

from __future__ import annotations

import threading

from halo_service.runtime.latest import Latest


def test_a_late_reader_gets_the_newest_and_the_rest_is_counted() -> None:
    latest: Latest[int] = Latest()
    for value in range(5):
        latest.put(value)
    assert latest.take(0.0) == 4
    assert latest.dropped == 4


def test_nothing_is_taken_twice() -> None:
    latest: Latest[int] = Latest()
    latest.put(0)
    assert latest.take(0.0) == 0
    assert latest.take(0.0) is None
    assert latest.peek() == 0


def test_a_waiting_reader_is_woken() -> None:
    latest: Latest[str] = Latest()
    got: list[str | None] = []
    reader = threading.Thread(target=lambda: got.append(latest.take(10.0)))
    reader.start()
    latest.put("frame")
    reader.join(10.0)
    assert got == ["frame"]
