"""The guided session under a real camera: what is asked for becomes the script."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from halo_calibration.errors import Refused
from halo_service.app.first_light import Ask, asked, conduct
from halo_service.evaluation.together import Played
from halo_service.values import BadFrame, Frame

FRAME_US = 33_333
UNIX_US = 1_700_000_000_000_000
NOTHING = np.zeros((2, 2), np.uint16)


def live(count: int) -> Iterator[Frame | BadFrame]:
    """Frames as a camera stamps them; every hundredth is bad."""
    for index in range(count):
        time_us = UNIX_US + index * FRAME_US
        bad = index % 100 == 99
        yield BadFrame(time_us, "torn") if bad else Frame(time_us, NOTHING, NOTHING)


def test_the_session_asks_for_the_papers_targets_heights_and_forces() -> None:
    steps = [ask.step for ask in asked()]
    assert {name: steps.count(name) for name in steps} == {
        "target": 32,
        "hover": 10,
        "pressure": 10,
    }
    assert 200.0 < sum(ask.ready_s + ask.seconds for ask in asked()) < 300.0


def test_what_is_asked_for_is_the_script_on_the_recordings_own_clock() -> None:
    asks = [
        Ask("Touch it.", 0.0, 2.0, "target", {"target_mm": [10.0, 20.0]}),
        Ask("Hold it.", 1.0, 3.0, "hover", {"height_mm": 5.0}),
    ]
    said: list[str] = []
    kept: list[Frame] = []
    lines = conduct(asks, Played(live(1000)), said.append, kept.append)
    assert said == ["Touch it.", "Hold it."]
    assert kept[0].time_us == 0
    assert [line["step"] for line in lines] == ["target", "hover"]
    assert lines[0]["target_mm"] == [10.0, 20.0]
    assert lines[1]["height_mm"] == 5.0
    times = [(line["from_s"], line["to_s"]) for line in lines]
    assert times[0] == pytest.approx((0.0, 2.0), abs=0.04)
    assert times[1] == pytest.approx((3.0, 6.0), abs=0.08)
    assert kept[-1].time_us / 1e6 == pytest.approx(times[1][1])


def test_a_camera_that_ends_in_mid_session_is_told() -> None:
    asks = [Ask("Touch it.", 0.0, 9.0, "target", {"target_mm": [10.0, 20.0]})]
    with pytest.raises(Refused, match="during 'target'"):
        conduct(asks, Played(live(60)), lambda _: None, lambda _: None)
