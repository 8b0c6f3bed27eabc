"""A musician's own strikes give the ends of the velocity curve."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, cast

import pytest

from halo_client import Receiver
from halo_midi.calibrate import STRIKES, curve, measured
from halo_protocol import UNKNOWN_STRIKE, TouchFrame


@pytest.mark.parametrize(
    ("strikes", "ends"),
    [
        ([*range(100, 300, 10)], (120, 270)),  # one in ten at each end is left out
        ([80.0] * 10 + [400.0] * 10, (80.0, 400.0)),
        ([100.0] * 20, (100.0, 150.0)),
        ([5.0] + [90.0] * 9 + [310.0] * 9 + [2000.0], (90.0, 310.0)),
    ],
)
def test_the_curve_leaves_out_the_odd_strike(
    strikes: list[float], ends: tuple[float, float]
) -> None:
    assert curve(strikes) == ends


def test_it_asks_for_strikes_and_counts_those_with_a_speed(wire: Any) -> None:
    class Scripted:
        url = "test://"

        def frames(self, timeout_s: float) -> Iterator[TouchFrame | None]:
            yield None
            down = wire.down()
            yield wire.frame(0, downs=(replace(down, strike_mm_s=UNKNOWN_STRIKE),))
            for number in range(2 * STRIKES):
                yield wire.frame(number, downs=(replace(down, strike_mm_s=100.0 + 10 * number),))

    printed: list[str] = []
    assert measured(cast("Receiver", Scripted()), printed.append) == (120.0, 270.0)
    assert printed[0].startswith("tap 20 times")
    assert "is `halo serve` running" in printed[1]
    assert printed[-1] == "20 of 20: 290 mm/s"
