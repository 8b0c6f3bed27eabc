"""HaloTouch's calibration with its own signal: four held states and a sweep (paper 4.3.5).

The same recordings, scripts and solvers as ours; only the signal is the paper's. It uses the same
base model as our calibration: relative strengths over place and angle, from pilots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from halo_calibration.base_model import VIRTUAL, read_base
from halo_calibration.observe import Observation
from halo_calibration.scripted.script import ScriptStep, parse_script, state_values_in
from halo_calibration.solvers.correction import Reference, solve_correction
from halo_calibration.solvers.sweep import SweepObservations, check_sweep
from halo_calibration.solvers.touch import (
    STATES,
    HoldObservations,
    StateValues,
    corrected,
    solve_touch,
)
from halo_service.evaluation.methods.paper.signal import read
from halo_service.profile import Correction, Profile
from halo_service.runtime.method import Script, Seen
from halo_service.sensing import SensingSettings
from halo_service.values import Frame, Tracked

SWEEP = "sweep"


def learn(profile: Profile, settings: SensingSettings, seen: Seen, script: Script) -> Profile:
    """Return the profile with the states and the correction of the paper's signal.

    Raises `UserError` where its states overlap or its sweep is not good enough.
    """
    del settings  # the paper's threshold is fixed
    lines = parse_script([dict(line) for line in script], "of the recording")
    received, observed = _watch(profile, seen, lines)

    def expected(step: str) -> int:
        line = next(line for line in lines if line.step == step)
        return round((line.to_s - line.from_s) * profile.camera.fps)

    holds = {
        state: HoldObservations(state, expected(state), received[state], tuple(observed[state]))
        for state in STATES
    }
    states, _, _ = solve_touch(holds, state_values_in(lines, StateValues()), None)
    correction: Correction | None = None
    if SWEEP in received:
        swept = SweepObservations(expected(SWEEP), received[SWEEP], tuple(observed[SWEEP]))
        samples = check_sweep(swept, profile.surface)
        held = states.touch
        at = Reference(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
        correction = solve_correction(profile.surface, read_base(VIRTUAL), samples, at)
    return replace(profile, touch=corrected(states, correction), by_hand={}, correction=correction)


def _watch(
    profile: Profile, seen: Seen, lines: Sequence[ScriptStep]
) -> tuple[dict[str, int], dict[str, list[Observation]]]:
    """Return the number of frames in each step, and the finger in those that show it."""
    received = {line.step: 0 for line in lines}
    observed: dict[str, list[Observation]] = {line.step: [] for line in lines}
    first_us: int | None = None
    for frame, tracked in seen:
        first_us = frame.time_us if first_us is None else first_us
        at_s = (frame.time_us - first_us) / 1e6
        for line in lines:
            if line.step != "background" and line.from_s <= at_s < line.to_s:
                received[line.step] += 1
                observed[line.step] += _observe(profile, frame, tracked)
    return received, observed


def _observe(profile: Profile, frame: Frame, tracked: Tracked) -> list[Observation]:
    """Return the index finger of the most confident hand, if there is one."""
    if not tracked.hands:
        return []
    hand = max(tracked.hands, key=lambda each: each.confidence)
    seen = read(frame.depth, hand, profile)
    return [
        Observation(
            frame.time_us,
            hand.side,
            *seen.place_mm,
            seen.pitch_deg,
            seen.yaw_deg,
            seen.top_mm,
            seen.raw,
            seen.raw,
            seen.line_px,
        )
    ]
