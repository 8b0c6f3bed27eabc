"""Unattended calibration: a script says when which step happens in a recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from halo_calibration import steps
from halo_calibration.observe import DetectHands, Observation, Observer
from halo_calibration.scripted.place import PLACE_STEPS, place_change
from halo_calibration.scripted.script import ScriptStep, state_values_in
from halo_calibration.solvers.touch import HELD_STATES, HoldObservations, check_hold
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.profile import Profile


class ScriptedCalibration:
    """Runs all steps of a script."""

    def __init__(
        self,
        setup: Setup,
        session: Session,
        detector_for: Callable[[Profile | None], DetectHands],
        say: Callable[[str], None],
    ) -> None:
        """`detector_for` gives a hand tracker for the profile as far as it is known."""
        self._setup = setup
        self._session = session
        self._detector_for = detector_for
        self._say = say
        self._helds: dict[str, HoldObservations] = {}
        self._observer: Observer | None = None

    def run(self, lines: tuple[ScriptStep, ...], profile: Profile | None = None) -> Profile:
        """Return the profile; `profile` provides what the script does not calibrate.

        Raises `CalibrationError` with the first error.
        """
        self._setup = replace(
            self._setup, state_values=state_values_in(lines, self._setup.state_values)
        )
        for line in lines:
            profile = self._calibrate(line, profile)
        assert profile is not None  # a script names a step, and each makes or needs a profile
        return profile

    def _calibrate(self, line: ScriptStep, profile: Profile | None) -> Profile:
        step, setup = line.step, self._setup
        frames = self._session.between(line.from_s, line.to_s, step)
        expected = self._session.frame_count(line.to_s - line.from_s)
        if step == "background":
            change = steps.background_change(setup, list(frames), self._detector_for(None))
            self._observer = None
        elif step in PLACE_STEPS:
            known = steps.require(profile, step)
            change = place_change(setup, line, frames, known, self._observer_for)
            if step == "surface":
                self._observer = None  # its places are in the old frame
        elif step in HELD_STATES:
            known = steps.require(profile, step)
            held = steps.watch_hold(step, frames, expected, self._observer_for(known), _ignore)
            check_hold(held)  # refused at once if it is not good
            self._helds[step] = held
            if len(self._helds) < len(setup.state_values.to_hold):
                return known
            change = steps.touch_change(setup, self._helds)
        else:
            known = steps.require(profile, step)
            swept = steps.watch_sweep(frames, expected, self._observer_for(known), _ignore)
            change = steps.sweep_change(setup, swept, known)
        profile = change(profile)
        self._say(f"{step}: done" if step not in HELD_STATES else "touch: done")
        return profile

    def _observer_for(self, profile: Profile) -> Observer:
        """Return one observer for all steps over the same background."""
        if self._observer is None:
            detect, settings = self._detector_for(profile), self._setup.settings
            self._observer = Observer(profile, detect, settings, self._setup.side)
        return self._observer


def _ignore(observation: Observation | None) -> None:
    """A recording has no live display."""
