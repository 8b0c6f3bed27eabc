"""Contacts of fingers that were not calibrated: only the index finger held the four states."""

from __future__ import annotations

import math

import pytest

from halo_service.sensing.contact import Evidence, contact_level, contact_probability
from halo_service.sensing.detector import Detector, detect
from halo_service.sensing.settings import SensingSettings

FRAME_US = 33_333
SETTINGS = SensingSettings()
NO_HALO, WAITING = -2.5, -1.5


def seen(level: float, calibrated: bool = False, waiting: float = WAITING) -> Evidence:
    return Evidence(level, 0.3, no_halo=NO_HALO, waiting=waiting, calibrated=calibrated)


def touches(*levels: float, neighbour_rise: float = 0.0, calibrated: bool = False) -> list[bool]:
    """Feed levels to a detector, one a frame, the last one twice, after a second at the first."""
    detector: Detector | None = None
    result = []
    for n, level in enumerate([*[levels[0]] * 30, *levels, levels[-1]]):
        rising = neighbour_rise if level > levels[0] else 0.0
        shown = seen(level, calibrated)
        detector = detect(detector, shown, n * FRAME_US, 0.0, SETTINGS, neighbour_rise=rising)
        result.append(detector.touching)
    return result


@pytest.mark.parametrize(("waits", "lands"), [(-1.7, -0.1), (-1.2, 0.9), (-0.3, 2.0), (0.2, 2.5)])
def test_a_tap_of_a_finger_that_reads_lower_or_higher_is_found(waits: float, lands: float) -> None:
    """The levels of virtual ring, index and middle fingers of open hands."""
    assert touches(waits, lands)[-2:] == [True, True]


@pytest.mark.parametrize("waits", [-1.5, -1.0, -0.5, 0.2])
def test_a_finger_that_waits_does_not_touch_however_it_reads(waits: float) -> None:
    assert not any(touches(waits, waits + 0.4, waits - 0.4, waits + 0.4))


def test_a_finger_that_comes_from_high_above_and_hangs_does_not_touch() -> None:
    """Where there was no halo, nothing says how this finger reads."""
    assert not any(touches(-2.4, -1.5, -0.5, -0.5, -0.5))
    meets, deviation = contact_level(seen(0.0), -2.4)
    assert (meets, deviation) == (0.5, pytest.approx(0.8))
    assert deviation > contact_level(seen(0.0), -1.2)[1]


def test_what_rises_because_its_neighbour_touches_does_not_touch() -> None:
    assert touches(-2.0, -0.1)[-1]
    assert not any(touches(-2.0, -0.1, neighbour_rise=2.6))
    assert touches(-2.0, 1.6, neighbour_rise=2.6)[-1]  # both touch


@pytest.mark.parametrize("level", [-0.5, 0.2, 0.8, 1.5])
def test_the_calibrated_finger_needs_no_rest_and_ignores_its_neighbours(level: float) -> None:
    alone = contact_probability(seen(level, calibrated=True), 0.0)
    assert (
        contact_probability(seen(level, calibrated=True), 0.0, rest=-0.3, neighbour_rise=3.0)
        == alone
    )


@pytest.mark.parametrize("waiting", [NO_HALO, NO_HALO - 1.0])
@pytest.mark.parametrize("rest", [math.nan, -9.0, NO_HALO, 0.0])
def test_a_hover_state_without_a_halo_is_ignored(waiting: float, rest: float) -> None:
    assert contact_level(seen(0.0, waiting=waiting), rest) == (0.5, pytest.approx(0.8))
