"""Guided calibration: a person is prompted, sees the signal, and may try again.

Rule: order and prompts only. What is seen becomes a profile in `steps`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol, TypeVar

from halo_calibration import steps
from halo_calibration.boards.board import Printed
from halo_calibration.errors import NO_HALO, CalibrationError
from halo_calibration.observe import DetectHands, Observation, Observer
from halo_calibration.solvers.background import WANTED_FRAMES
from halo_calibration.solvers.sweep import SWEEP_S, SweepObservations, covered, draw_map, samples_of
from halo_calibration.solvers.touch import HOLD_S, HoldObservations, check_hold
from halo_calibration.steps import Change, Setup
from halo_calibration.steps.camera import LOOK_S, CameraReport, camera_report
from halo_calibration.steps.session import Session
from halo_service.profile import Profile
from halo_service.values import Frame

ATTEMPTS = 3
"""So often a step may be refused before we give up."""
READY_S = 3.0
"""The count-down before something is measured."""

T = TypeVar("T")


class Prompt(NamedTuple):
    """What the person shall do now; a virtual user takes it by its name."""

    name: str
    """background, hover, subtle, touch, pressure, hard, sweep or pilot; sheet, corner, board, cross
    or marker; of first light: spot, tap, level or away."""
    words: str
    pitch_deg: float = 45.0
    """The wedge's."""
    number: int = 0
    """Which corner."""
    at_px: tuple[float, float] = (0.0, 0.0)
    """Where a cross is, in the projector's pixels."""
    board: Printed | None = None
    """What lies on the table."""
    at_mm: tuple[float, float] = (0.0, 0.0)
    """Where a touch or tap is, on the surface."""
    height_mm: float = 0.0
    """Of a level."""
    force_g: float = 0.0
    """Of a level in touch."""


PROMPTS = {
    "background": Prompt("background", "Clear the surface: no hands, nothing that moves in view."),
    "hover": Prompt(
        "hover",
        "HOVER: hold the index finger 10 mm above the middle of the surface, where the halo just "
        "shows (resting on a peg, if you have one, that is narrower than the fingertip), the other "
        "fingers curled.",
    ),
    "subtle": Prompt("subtle", "SUBTLE: as near as you can without touching, about 1 mm above."),
    "touch": Prompt("touch", "TOUCH: let the fingertip rest on the surface, relaxed."),
    "pressure": Prompt("pressure", "PRESSURE: press down with medium force."),
    "hard": Prompt("hard", "HARD: press as hard as you stated (--hard-g), and no harder."),
    "sweep": Prompt(
        "sweep",
        "SWEEP: rest the finger on the 45 degree wedge, its tip on the surface, and draw it over "
        "the whole surface, out to the edges, turning it a little to both sides.",
    ),
}


class Guide(Protocol):
    """How the person is prompted: a terminal, or a test."""

    def prompt(self, prompt: Prompt) -> None:
        """Say what to do now."""

    def say(self, words: str) -> None:
        """Say how something went."""

    def live(self, seconds_left: float, measuring: bool, seen: Observation | str | None) -> None:
        """Show the count-down, and the finger's signal or what else is seen, in words."""

    def map(self, lines: list[str]) -> None:
        """Show what of the surface is covered."""


class GuidedCalibration:
    """One guided calibration."""

    def __init__(
        self,
        setup: Setup,
        session: Session,
        guide: Guide,
        detector_for: Callable[[Profile | None], DetectHands],
        hold_s: float = HOLD_S,
    ) -> None:
        """`detector_for` gives a hand tracker for the profile as far as it is known."""
        self.setup = setup
        self.session = session
        self.guide = guide
        self._detector_for = detector_for
        self._hold_s = hold_s
        self.left_s = 0.0

    def camera(self) -> CameraReport:
        """Judge where the camera is, what it measures, and how bright it is."""
        self.guide.prompt(PROMPTS["background"])
        frames = []
        for frame in self.timed("camera", LOOK_S):
            self.guide.live(self.left_s, True, "looking at the empty table")
            frames.append(frame)
        return camera_report(frames, self.setup.camera)

    def background(self) -> Change:
        """Calibrate the empty surface."""
        detect = self._detector_for(None)

        def attempt() -> Change:
            self.guide.prompt(PROMPTS["background"])
            for _ in self.timed("background", READY_S):
                self.guide.live(self.left_s, False, None)
            frames = []
            for frame in self.timed("background", WANTED_FRAMES / self.setup.camera.fps):
                self.guide.live(self.left_s, True, None)
                frames.append(frame)
            return steps.background_change(self.setup, frames, detect)

        return self.until_good(attempt)

    def touch(self, profile: Profile) -> Change:
        """Calibrate the held states; a state that is not still is done again at once, the set once
        more where they overlap."""
        observer = self.observer(profile)

        def one(state: str) -> HoldObservations:
            held = self._held(state, observer)
            check_hold(held)
            return held

        def attempt() -> Change:
            states = self.setup.state_values.to_hold
            holds = {state: self.until_good(lambda s=state: one(s)) for state in states}  # type: ignore[misc]
            return steps.touch_change(self.setup, holds)

        return self.until_good(attempt)

    def sweep(self, profile: Profile) -> Change:
        """Calibrate the correction from the sweep."""
        observer = self.observer(profile)

        def attempt() -> Change:
            swept = self.swept(PROMPTS["sweep"], SWEEP_S, observer, profile)
            return steps.sweep_change(self.setup, swept, profile)

        return self.until_good(attempt)

    def swept(
        self, prompt: Prompt, seconds: float, observer: Observer, profile: Profile
    ) -> SweepObservations:
        """Let the person sweep once, with the live map of what is covered."""
        self.guide.prompt(prompt)
        self._ready(prompt.name, observer)
        seen: list[Observation] = []

        def watch(observation: Observation | None) -> None:
            if observation is not None:
                seen.append(observation)
            self.guide.map(draw_map(covered(samples_of(seen), profile.surface)))
            self.guide.live(self.left_s, True, observation)

        frames = self.timed(prompt.name, seconds)
        return steps.watch_sweep(frames, self.session.frame_count(seconds), observer, watch)

    def observer(self, profile: Profile) -> Observer:
        """Return an observer for a profile's background."""
        setup = self.setup
        return Observer(profile, self._detector_for(profile), setup.settings, setup.side)

    def _held(self, state: str, observer: Observer) -> HoldObservations:
        self.guide.prompt(PROMPTS[state])
        self._ready(state, observer)
        expected = self.session.frame_count(self._hold_s)

        def watch(observation: Observation | None) -> None:
            self.guide.live(self.left_s, True, observation)

        return steps.watch_hold(state, self.timed(state, self._hold_s), expected, observer, watch)

    def _ready(self, during: str, observer: Observer) -> None:
        """Count down, with the live signal."""
        for frame in self.timed(during, READY_S):
            self.guide.live(self.left_s, False, observer.see(frame))

    def timed(self, during: str, seconds: float) -> Iterator[Frame]:
        """Yield frames for a while, and keep how much of it is left."""
        first_us: int | None = None
        for frame in self.session.lasting(seconds, during):
            first_us = frame.time_us if first_us is None else first_us
            self.left_s = seconds - (frame.time_us - first_us) / 1e6
            yield frame

    def until_good(self, attempt: Callable[[], T]) -> T:
        for left in reversed(range(ATTEMPTS)):
            try:
                return attempt()
            except CalibrationError as refused:
                if left == 0 or NO_HALO in str(refused):
                    raise
                self.guide.say(f"{refused}.")
        raise AssertionError("the last attempt returns or raises")
