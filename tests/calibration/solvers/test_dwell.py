"""A touch is separated from a pause, a pass and a long rest, without knowing the finger."""

from __future__ import annotations

from dataclasses import replace

import pytest

from halo_calibration.observe import Observation
from halo_calibration.solvers.dwell import Dwells, touches
from halo_service.values import Side

FPS = 30.0
Stretch = tuple[float, float, float, float]
"""Seconds, x, y, raw signal."""


def finger(*stretches: Stretch | float) -> list[Observation | None]:
    """One stretch after the other; a number alone is so long without a finger."""
    seen: list[Observation | None] = []
    for stretch in stretches:
        if isinstance(stretch, float):
            seen += [None] * round(stretch * FPS)
            continue
        seconds, x, y, raw = stretch
        for n in range(round(seconds * FPS)):
            off = 0.8 * (-1) ** n
            seen.append(Observation(0, Side.RIGHT, x + off, y - off, 45.0, 0.0, 14.0, raw, raw, 5))
    return seen


def passing(seconds: float, raw: float) -> list[Stretch]:
    count = round(seconds * FPS)
    return [(1.0 / FPS, 10.0 * n, 50.0, raw) for n in range(count)]


TOUCH = (0.8, 100.0, 50.0, 2000.0)
UP = (0.3, 100.0, 50.0, 0.0)

CASES = [
    ("one touch", [TOUCH], 1),
    ("a long rest is one touch", [(4.0, 100.0, 50.0, 2000.0)], 1),
    ("three touches at one place", [TOUCH, UP, TOUCH, UP, TOUCH], 3),
    ("a finger moved on unseen", [TOUCH, (0.8, 200.0, 50.0, 1900.0)], 2),
    ("a pause above the surface", [TOUCH, UP, (1.0, 100.0, 50.0, 450.0), TOUCH], 2),
    ("no halo at all", [(1.0, 100.0, 50.0, 20.0)], 0),
    ("a tap too short to be placed", [(0.2, 100.0, 50.0, 2000.0), UP], 0),
    ("a finger that is drawn over the surface", passing(2.0, 2000.0), 0),
    ("the tracker loses the finger for a moment", [(0.2, 100.0, 50.0, 2000.0), 0.1, TOUCH], 1),
    ("the tracker loses a finger that rests", [TOUCH, 0.5, TOUCH], 1),
]  # fmt: skip


@pytest.mark.parametrize(
    ("stretches", "count"), [case[1:] for case in CASES], ids=[c[0] for c in CASES]
)
def test_touches_are_counted(stretches: list[Stretch | float], count: int) -> None:
    assert len(touches(finger(*stretches), Dwells(FPS), 9)) == count


def test_a_touch_is_where_the_finger_stood() -> None:
    (place,) = touches(finger(TOUCH), Dwells(FPS), 1)
    assert place == pytest.approx((100.0, 50.0), abs=1.0)


@pytest.mark.parametrize(
    ("known_mm", "behind_mm", "back_mm"), [(None, -2.0, 0.0), (None, 6.0, 8.0), (12.0, -2.0, 8.49)]
)
def test_a_touch_is_under_a_long_nail(
    known_mm: float | None, behind_mm: float, back_mm: float
) -> None:
    """As measured in the touch itself, or by the held states where these are known."""
    seen = [each and replace(each, halo_behind_mm=behind_mm) for each in finger(TOUCH)]
    (place,) = touches(seen, Dwells(FPS, nail_mm=known_mm), 1)
    assert place == pytest.approx((100.0, 50.0 + back_mm), abs=1.0)


def test_a_weak_halo_is_no_touch_where_the_finger_is_known() -> None:
    weak = finger((1.0, 100.0, 50.0, 500.0))
    assert len(touches(weak, Dwells(FPS), 9)) == 1
    assert not touches(weak, Dwells(FPS, least_raw=800.0), 9)
