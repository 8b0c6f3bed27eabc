"""How fast a finger goes, and strikes."""

from __future__ import annotations

import math

import pytest

from halo_service.sensing.pointers import FITTED, Motion, Place

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
