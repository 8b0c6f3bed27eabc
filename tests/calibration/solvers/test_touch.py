"""The four states are taken when they are still, apart and in order, and refused in a sentence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from halo_calibration.errors import NO_HALO, CalibrationError
from halo_calibration.solvers.touch import (
    STATES,
    HoldObservations,
    StateValues,
    corrected,
    solve_touch,
)
from halo_calibration.steps import NO_DENTS, NO_HARD, Setup, touch_change
from halo_service.profile import Correction, Profile, TouchStates
from halo_service.sensing.states import span
from halo_service.values import Signal

Hold = Callable[..., HoldObservations]
RAW = {"hover": 300.0, "subtle": 1500.0, "touch": 2200.0, "pressure": 2800.0}


def all_of(hold: Hold, **other: HoldObservations) -> dict[str, HoldObservations]:
    return {state: other.get(state) or hold(state, RAW[state]) for state in STATES}


def test_states_are_medians_with_what_was_stated(hold: Hold) -> None:
    states, apart, quality = solve_touch(
        all_of(hold), StateValues(hover_mm=12.0, subtle_mm=2.0, pressure_g=250.0), None
    )
    assert states.touch.signal == pytest.approx(2200.0, abs=10.0)
    assert (states.hover.height_mm, states.hover.stated) == (12.0, True)
    assert (states.pressure.force_g, states.pressure.stated) == (250.0, True)
    assert (states.touch.force_g, states.touch.stated) == (25.0, False)
    # Off the hover state, 12 mm up: nearer to the surface the halo lifts what the camera reads.
    assert states.finger_thickness_mm == 14.0
    assert states.tip_radius_mm == 6.5
    assert [getattr(states, name).readings[1] for name in STATES] == [1.5, 7.5, 11.0, 14.0]
    assert quality == "good"
    assert apart > 6.0


def test_what_was_not_measured_is_recorded_as_assumed(hold: Hold) -> None:
    states, _, _ = solve_touch(all_of(hold), StateValues(), None)
    assert [getattr(states, name).stated for name in STATES] == [False] * 4
    assert (states.hover.height_mm, states.subtle.height_mm) == (10.0, 1.0)
    assert states.pressure.force_g == -1.0


def test_a_hover_state_must_be_above_the_subtle_one(hold: Hold) -> None:
    with pytest.raises(CalibrationError, match="not above the subtle one"):
        solve_touch(all_of(hold), StateValues(hover_mm=1.0), None)


def test_states_held_elsewhere_have_their_upper_sides_leveled_once(hold: Hold) -> None:
    """The grid rises by a millimetre for each 10 mm to the right of where the sweep began."""
    states, _, _ = solve_touch(all_of(hold), StateValues(), None)
    x_mm, y_mm = np.array([0.0, 300.0], np.float32), np.array([0.0, 200.0], np.float32)
    two, ones = np.array([15.0, 75.0], np.float32), np.ones((2, 2), np.float32)
    higher_mm = (x_mm[:, None] - 150.0) / 10.0 * ones
    correction = Correction(
        x_mm, y_mm, two, two, np.ones((2, 2, 2, 2), np.float32), np.empty((0, 9)), "",
        tops_mm=np.stack([higher_mm, ones]),
    )  # fmt: skip
    hover = replace(states.hover, x_mm=230.0)
    there = corrected(replace(states, hover=hover), correction)
    assert states.hover.raw_top_mm is not None
    assert there.hover.top_mm == pytest.approx(states.hover.raw_top_mm - 8.0)
    again = corrected(there, correction)
    assert again.hover.top_mm == there.hover.top_mm
    assert corrected(again, None).hover.top_mm == states.hover.raw_top_mm
    old = corrected(replace(states, hover=replace(hover, raw_top_mm=None)), correction)
    assert old.hover.top_mm == there.hover.top_mm


CASES = {
    "moved": ("touch", {"raw": 2200.0, "moved_mm": 30.0}, "moved by .* during 'touch': rest"),
    "dropped": (
        "hover",
        {"raw": 300.0, "received": 20},
        "only 20 of 60 frames came during 'hover'",
    ),
    "lost": ("subtle", {"raw": 1500.0, "seen": 20}, "found in only 20 of 60 .* 'subtle'"),
    "swapped": (
        "hover",
        {"raw": 2000.0, "dent_mm": 9.0},
        "'hover' shows a stronger halo than 'subtle'",
    ),
    "overlap": (
        "subtle",
        {"raw": 2190.0, "dent_mm": 11.0},
        "'subtle' and 'touch' overlap .* keep clear",
    ),
    "no press": (
        "pressure",
        {"raw": 2210.0, "dent_mm": 11.0},
        "'touch' and 'pressure' overlap .* press down",
    ),
}


@pytest.mark.parametrize(("state", "how", "says"), CASES.values(), ids=CASES.keys())
def test_bad_states_are_refused_with_the_remedy(
    hold: Hold, state: str, how: dict[str, float], says: str
) -> None:
    with pytest.raises(CalibrationError, match=says):
        solve_touch(all_of(hold, **{state: hold(state, **how)}), StateValues(), None)


WITH_HARD = StateValues(pressure_g=200.0, hard_g=400.0)


def test_a_hard_press_is_held_and_corrected_like_the_others(hold: Hold) -> None:
    holds = all_of(hold) | {"hard": hold("hard", 3300.0)}
    states, _, quality = solve_touch(holds, WITH_HARD, None)
    assert states.hard is not None
    assert (states.hard.signal, states.hard.force_g) == (pytest.approx(3300.0, abs=10.0), 400.0)
    assert quality == "good"
    stale = replace(states, hard=replace(states.hard, signal=0.0))
    assert corrected(stale, None).hard == states.hard
    assert solve_touch(all_of(hold), StateValues(), None)[0].hard is None


def test_a_hard_press_that_the_halo_does_not_show_is_left_out_with_a_note(
    hold: Hold, profile: Profile
) -> None:
    holds = all_of(hold) | {"hard": hold("hard", RAW["pressure"])}
    assert solve_touch(holds, WITH_HARD, None)[0].hard is None
    setup = Setup("desk", profile.camera, "2024-05-01", state_values=WITH_HARD)
    after = touch_change(setup, holds)(profile)
    assert NO_HARD in after.steps["touch"].note


@pytest.mark.parametrize(
    ("forces_g", "says"),
    [((None, 400.0), "needs the grams of the medium one"), ((200.0, 210.0), "too near")],
)
def test_a_hard_press_needs_a_medium_one_below_it(
    forces_g: tuple[float | None, float], says: str
) -> None:
    with pytest.raises(CalibrationError, match=says):
        StateValues(pressure_g=forces_g[0], hard_g=forces_g[1])


@pytest.mark.parametrize("value", [-5.0, float("nan"), float("inf"), 1e9])
def test_an_impossible_stated_value_is_refused(value: float) -> None:
    with pytest.raises(CalibrationError, match=r"impossible; give mm or grams in range 0\.\.5000"):
        StateValues(pressure_g=value)


def test_a_surface_without_a_halo_gets_its_verdict(hold: Hold) -> None:
    flat = {state: hold(state, 5.0, noise=3.0) for state in STATES}
    with pytest.raises(CalibrationError) as refused:
        solve_touch(flat, StateValues(), None)
    assert str(refused.value) == NO_HALO


def test_states_that_are_only_just_apart_are_fair(hold: Hold) -> None:
    press = hold("pressure", 2600.0, noise=100.0, dent_mm=11.8, sways_mm=0.2)
    assert solve_touch(all_of(hold, pressure=press), StateValues(), None)[2] == "fair"


def test_a_halo_too_weak_for_the_signal_is_calibrated_by_its_depths(hold: Hold) -> None:
    depths = {"hover": 1.0, "subtle": 2.0, "touch": 3.0, "pressure": 5.0}
    holds = {state: hold(state, 0.0, dent_mm=mm, sways_mm=0.1) for state, mm in depths.items()}
    states, apart, _ = solve_touch(holds, StateValues(), None)
    assert dents(states) == pytest.approx(list(depths.values()), abs=0.11)
    assert apart > 6.0


def dents(states: TouchStates) -> list[float]:
    """Of each state; 0 where it was hidden."""
    return [getattr(states, name).readings[1] for name in STATES]


def sums_alone(states: TouchStates) -> list[str]:
    """The pairs between which only the sum weighs anything."""
    signal = Signal(1.0, 1.0, (1.0,) * 4)
    return [
        high
        for low, high in pairwise(STATES)
        if span(signal, getattr(states, low), getattr(states, high)).weights[0] == 1.0
    ]


UNSEPARATE = {
    "alike": ("touch", {"dent_mm": 7.5}, ["touch"]),
    "swapped": ("subtle", {"dent_mm": 12.0}, ["touch"]),
    "hidden in most frames": ("hover", {"hidden": 31}, ["subtle"]),
    "hidden": ("pressure", {"hidden": 60}, ["pressure"]),
    "unsteady": ("pressure", {"dent_mm": 11.3, "sways_mm": 0.5}, ["pressure"]),
}


@pytest.mark.parametrize(("state", "how", "pairs"), UNSEPARATE.values(), ids=UNSEPARATE.keys())
def test_depths_that_do_not_separate_two_states_weigh_nothing_between_them_and_refuse_no_user(
    hold: Hold, profile: Profile, state: str, how: dict[str, float], pairs: list[str]
) -> None:
    holds = all_of(hold, **{state: hold(state, RAW[state], **how)})
    states, apart, quality = solve_touch(holds, StateValues(), None)
    assert sums_alone(states) == pairs
    assert states.touch.signal == pytest.approx(2200.0, abs=10.0)
    assert apart > 6.0
    assert quality == "fair"
    after = touch_change(Setup("desk", profile.camera, "2024-05-01"), holds)(profile)
    assert after.steps["touch"].note.endswith(NO_DENTS)


def test_unknown_dents_stay_unknown_when_a_sweep_comes(hold: Hold) -> None:
    states, _, _ = solve_touch(
        all_of(hold, touch=hold("touch", 2200.0, hidden=60)), StateValues(), None
    )
    ends = np.array([0.0, 300.0], np.float32)
    flat = np.ones((2, 2, 2, 2), np.float32)
    grids = np.full((4, 2, 2), 0.5, np.float32)
    correction = Correction(
        ends, ends, ends, ends, flat, np.empty((0, 8), np.float32), "", grids, grids
    )
    assert dents(corrected(states, correction)) == [3.0, 15.0, 0.0, 28.0]


SEPARATE = {
    "four times as far apart as they vary": {"dent_mm": 11.8, "sways_mm": 0.2},
    "seen in every other frame": {"hidden": 30},
}


@pytest.mark.parametrize("how", SEPARATE.values(), ids=SEPARATE.keys())
def test_dents_that_separate_the_states_are_used_without_a_note(
    hold: Hold, profile: Profile, how: dict[str, float]
) -> None:
    holds = all_of(hold, pressure=hold("pressure", RAW["pressure"], **how))
    states, _, quality = solve_touch(holds, StateValues(), None)
    assert dents(states) == [1.5, 7.5, 11.0, how.get("dent_mm", 14.0)]
    assert quality == "good"
    after = touch_change(Setup("desk", profile.camera, "2024-05-01"), holds)(profile)
    assert NO_DENTS not in after.steps["touch"].note


@pytest.mark.parametrize(
    ("behind_mm", "nail_mm"), [(-5.0, 0.0), (-1.0, 0.0), (4.0, 8.5), (40.0, 15.0), (math.nan, 0.0)]
)
def test_a_halo_far_behind_the_outline_shows_a_long_nail(
    hold: Hold, behind_mm: float, nail_mm: float
) -> None:
    holds = all_of(hold)
    for state in ("touch", "pressure"):
        seen = tuple(
            replace(each, halo_behind_mm=behind_mm, pitch_deg=45.0)
            for each in holds[state].observations
        )
        holds[state] = replace(holds[state], observations=seen)
    states, _, _ = solve_touch(holds, StateValues(), None)
    assert states.nail_mm == pytest.approx(nail_mm, abs=0.1)
