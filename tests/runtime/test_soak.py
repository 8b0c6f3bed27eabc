"""The soak's client counts what would spoil an evening, so its run can fail."""

from __future__ import annotations

import sys

import pytest

from halo_protocol import Down, Lost, Pointer, TouchFrame

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the soak needs Linux")


def pointer(state: int, contacts: int = 1) -> Pointer:
    return Pointer(
        7, 0, 2, 1, state, 0.5, 0.5, 150.0, 100.0, 0.0, 0.5, 0.0, 0.0, 0.9, contacts, -1.0
    )


def frame(number: int, *pointers: Pointer, downs: tuple[Down, ...] = ()) -> TouchFrame:
    return TouchFrame("table", "soak", "s1", number, number * 33_333, pointers, downs=downs)


def test_a_pointer_that_stays_is_stuck_and_one_that_taps_is_not() -> None:
    from benchmarks.soaking.client import Seen

    seen = Seen()
    for n in range(90):  # three seconds of taps
        touching = n % 15 < 6
        seen.update(frame(n, pointer(int(touching), 1 + n // 15)), n / 30)
    assert not seen.stuck
    for n in range(90, 150):
        seen.update(frame(n, pointer(1, 9)), n / 30)
    assert seen.stuck == {("s1", 7)}


def test_a_lost_service_leaves_no_touch_and_a_gap_is_counted() -> None:
    from benchmarks.soaking.client import Seen

    seen = Seen()
    down = Down(7, 0, 0.5, 0.5, 100.0, 3.0, 1)
    seen.update(frame(0, pointer(1), downs=(down,)), 0.0)
    seen.update(frame(1), 2.0)
    seen.update(Lost("table", "soak", "s1"), 3.0)
    seen.update(frame(2), 13.6)
    assert (seen.gaps, seen.longest_gap_s, seen.downs) == (1, 2.0, 1)
    assert not seen.stuck and not seen.open


def test_each_fault_of_the_soak_changes_what_the_camera_gives() -> None:
    from tests.faults import Faults, FaultyCamera

    faults = Faults()
    camera = FaultyCamera(faults)
    plain = camera.read(0.1)
    assert plain is not None and plain.depth.any()
    faults.begin("black")
    black = camera.read(0.1)
    faults.end("black")
    faults.begin("time ahead")
    ahead = camera.read(0.1)
    faults.end("time ahead")
    assert black is not None and not black.depth.any()
    assert ahead is not None and ahead.time_us - black.time_us > 9_000_000
    faults.begin("unplugged")
    with pytest.raises(Exception, match="went away"):
        camera.read(0.1)
    with pytest.raises(Exception, match="no camera is plugged in"):
        FaultyCamera(faults)
    faults.end("unplugged")
    faults.begin("another device")
    assert FaultyCamera(faults).camera.serial == "OTHER"


GOOD = {"memory_mb": (500.0, 505.0), "ended_empty": True}


@pytest.mark.parametrize(
    ("changed", "row", "stuck", "log", "code"),
    [
        ({}, (0.1, 0.5), set(), "", 0),
        ({}, (0.1, 0.5), set(), "Traceback (most\nRuntimeError: the model is broken", 0),
        ({}, (0.1, 0.5), set(), "Traceback (most\nKeyError: 3", 1),
        ({}, (0.1, 0.5), {("s1", 7)}, "", 1),
        ({}, (None, 0.5), set(), "", 1),
        ({}, (0.1, 1.6), set(), "", 1),
        ({}, (0.1, None), set(), "", 1),
        ({"memory_mb": (500.0, 511.0)}, (0.1, 0.5), set(), "", 1),
        ({"ended_empty": False}, (0.1, 0.5), set(), "", 1),
    ],
)
def test_one_fault_of_the_service_fails_the_soak(changed, row, stuck, log, code) -> None:
    from benchmarks.soaking.client import Seen
    from benchmarks.soaking.figures import Figures, Row
    from benchmarks.soaking.result import result

    rows = [Row("black", 0.1, 0.5), Row("stalls", *row)]
    assert result(Figures(rows, **{**GOOD, **changed}), Seen(stuck=stuck), log) == code
