"""The step of the held states: hover, subtle, touch, pressure, and hard if it is wanted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from halo_calibration.observe import Observer
from halo_calibration.solvers.touch import (
    HARD,
    HoldObservations,
    StateValues,
    dents_known,
    solve_touch,
)
from halo_calibration.steps.change import Change, Setup, Watch, require, rounded, watched
from halo_service.profile import Profile, StepRecord, TouchStates
from halo_service.values import Frame, Side

NO_DENTS = (
    "the dent under the fingertip was hidden or hardly deeper in one state than in the one before, "
    "so touch and force are read off the halo's strength and height off the finger's own depth"
)
"""Said of the four states."""
NO_HARD = (
    "the hard press read no stronger than the medium one, so forces beyond that are extrapolated"
)


def watch_hold(
    state: str, frames: Iterable[Frame], expected: int, observer: Observer, watch: Watch
) -> HoldObservations:
    """Watch a finger that is held in one of the states."""
    received, observations = watched(frames, observer, watch)
    return HoldObservations(state, expected, received, observations)


def touch_change(setup: Setup, holds: Mapping[str, HoldObservations]) -> Change:
    """Calibrate the held states. Raises `CalibrationError` if they are not good enough."""
    solve_touch(holds, setup.state_values, None)

    def change(before: Profile | None) -> Profile:
        known = require(before, "touch")
        states, apart, quality = solve_touch(holds, setup.state_values, known.correction)
        by_hand = dict(known.by_hand)
        everyone = states
        if setup.side is not Side.UNKNOWN:
            by_hand[setup.side] = states
            everyone = known.touch or states
        record = StepRecord(
            setup.date,
            quality,
            rounded(
                separation_sigmas=apart,
                **{
                    f"{name}_mm_px": state.raw
                    for name in holds
                    if (state := getattr(states, name)) is not None
                },
            ),
            _touch_note(setup.state_values, states, HARD in holds),
        )
        return replace(
            known, touch=everyone, by_hand=by_hand, steps={**known.steps, "touch": record}
        )

    return change


def _touch_note(state_values: StateValues, states: TouchStates, hard_held: bool) -> str:
    heights = state_values.of("hover")[2] and state_values.of("subtle")[2]
    force = state_values.of("pressure")[2]
    parts = [
        "" if heights else "heights are assumed (10 and 1 mm)",
        "" if force else "the press's force is unknown, so no grams are reported",
        "" if dents_known(states) else NO_DENTS,
        NO_HARD if hard_held and states.hard is None else "",
    ]
    return "; ".join(part for part in parts if part)
