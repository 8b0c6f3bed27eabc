"""Measurements become parts of a profile."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.profile.fit import fit_background, fit_states
from halo_service.values import Signal

STATED = {"hover_mm": 10.0, "subtle_mm": 1.0, "touch_g": 25.0, "pressure_g": 200.0}


def held(**signals: float) -> dict[str, list[Signal]]:
    return {
        name: [Signal(value + off, value + off, 5) for off in (-20.0, 0.0, 900.0)]
        for name, value in signals.items()
    }


def test_a_background_is_the_mean_of_what_was_measured() -> None:
    frames = [np.array([[500, 0, 600]], np.uint16), np.array([[504, 0, 0]], np.uint16)]
    background = fit_background(frames)
    assert background.mean_mm.tolist() == [[502.0, 0.0, 600.0]]
    assert background.noise_mm.tolist() == [[2.0, 0.0, 0.0]]
    assert background.valid.tolist() == [[True, False, False]]


def test_45_good_frames_of_60_suffice() -> None:
    frames = [np.array([[500, 500]], np.uint16)] * 44 + [np.array([[0, 500]], np.uint16)]
    frames += [np.zeros((1, 2), np.uint16)] * 15
    assert fit_background(frames).valid.tolist() == [[False, True]]


def test_no_frames_are_no_background() -> None:
    with pytest.raises(ValueError, match="at least one"):
        fit_background([])


def test_states_are_medians() -> None:
    states = fit_states(
        held(hover=500, subtle=1500, touch=2000, pressure=3000),
        [13.0, float("nan"), 15.0],
        **STATED,
    )
    assert states.touch.signal == 2000.0
    assert states.pressure.force_g == 200.0
    assert states.finger_thickness_mm == 14.0
    assert states.line_px_at_hover == 5.0


@pytest.mark.parametrize(
    ("signals", "says"),
    [
        ({"hover": 500, "subtle": 1500, "touch": 2000}, "no signal .* pressure"),
        ({"hover": 500, "subtle": 2100, "touch": 2000, "pressure": 3000}, "must grow"),
        ({"hover": 0, "subtle": 0, "touch": 0, "pressure": 0}, "must grow"),
    ],
)
def test_states_out_of_order_are_refused(signals: dict[str, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        fit_states(held(**signals), [], **STATED)
