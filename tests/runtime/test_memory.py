"""Memory that grows and does not stop is noticed once, and only when it is much."""

from __future__ import annotations

import mmap
import sys

import pytest

from halo_service.runtime.memory import LEAK_MB, UNKNOWN, MemoryWatch, memory_mb


def noticed(used: dict[float, int]) -> list[float]:
    watch = MemoryWatch()
    return [at_s for at_s, used_mb in used.items() if watch.leaks(at_s, used_mb)]


def test_loading_libraries_is_no_leak_and_a_leak_is_noticed_once() -> None:
    loading = {0.0: 50, 10.0: 900, 29.0: 350}
    steady = {31.0: 350, 40.0: 340, 50.0: 360}
    leak = {60.0: 340 + LEAK_MB - 1, 61.0: 340 + LEAK_MB, 62.0: 340 + LEAK_MB + 50}
    assert noticed(loading | steady | leak) == [61.0]
    again = {92.0: 800, 93.0: 800 + LEAK_MB}
    assert noticed(loading | steady | leak | again) == [61.0, 93.0]


def test_where_memory_is_unknown_nothing_leaks() -> None:
    assert noticed({float(second): UNKNOWN for second in range(0, 300, 10)}) == []


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")
def test_memory_is_that_of_this_process() -> None:
    before = memory_mb()
    with mmap.mmap(-1, 60_000_000) as block:
        block.write(bytes(60_000_000))
        assert memory_mb() - before == pytest.approx(60, abs=15)
