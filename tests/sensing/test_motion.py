"""How fast a finger goes, and strikes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halo_service.geometry.surface import Surface
from halo_service.sensing.pointers import FITTED, Motion, Place, came_over_edge

FRAME_US = 33_333


def places(heights: list[float], tops: list[float] | None = None) -> tuple[Place, ...]:
    tops = tops or [height + 14.0 for height in heights]
    return tuple(
        Place(n * FRAME_US, 0.0, 0.0, height, top)
        for n, (height, top) in enumerate(zip(heights, tops, strict=True))
    )


@pytest.mark.parametrize("fall_mm_s", [60.0, 150.0, 600.0])
@pytest.mark.parametrize("into_frame", [0.1, 0.5, 0.9])
def test_an_even_fall_is_the_strike(fall_mm_s: float, into_frame: float) -> None:
    contact_us = (3 + into_frame) * FRAME_US
    heights = [fall_mm_s * (contact_us - n * FRAME_US) / 1e6 for n in range(FITTED)]
    strike = Motion(places(heights)).strike_mm_s(contact_us)
    assert strike == pytest.approx(fall_mm_s, rel=0.01)


@pytest.mark.parametrize("heights", [[], [8.0], [3.0, 5.0, 8.0]], ids=["none", "one", "rising"])
def test_a_strike_is_never_negative(heights: list[float]) -> None:
    assert Motion(places(heights)).strike_mm_s(3.5 * FRAME_US) >= 0.0


def test_an_unmeasured_upper_side_says_nothing_of_the_strike() -> None:
    heights = [20.0, 15.0, 10.0, 5.0]
    hidden = Motion(places(heights, [math.nan] * 4)).strike_mm_s(4 * FRAME_US)
    assert hidden == pytest.approx(150.0, rel=0.01)


@pytest.mark.parametrize(
    ("xs", "came_in"),
    [
        ((50.0,), False),
        ((-8.0, -7.0), True),
        ((20.0, 30.0), True),
        ((20.0, 30.0, 40.0), True),
        ((40.0, 50.0), False),
        ((20.0, 20.0), False),
        ((20.0, 10.0), False),
        ((290.0, 280.0), True),
    ],
    ids=[
        "new", "outside", "sliding in", "still sliding", "too far in", "at rest", "sliding out",
        "from the right",
    ],
)  # fmt: skip
def test_a_finger_came_over_the_edge_if_it_was_outside_just_before(
    xs: tuple[float, ...], came_in: bool
) -> None:
    surface = Surface("table", 300.0, 200.0, np.eye(4))
    *before, now = (Place(n * FRAME_US, x, 90.0, 0.0, 14.0) for n, x in enumerate(xs))
    moved = Motion(tuple(before))
    assert came_over_edge(moved, (now.x_mm, now.y_mm), now.time_us, surface) is came_in
