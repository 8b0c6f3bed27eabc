"""`halo calibrate`: run the steps that make a profile."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

from halo_calibration.base_model import choose_base, pilot_path, read_base, write_base
from halo_calibration.guided.guide import GuidedCalibration, Prompt
from halo_calibration.guided.pilot import merged, pilot_rounds, pilot_samples
from halo_calibration.guided.projector import Screen
from halo_calibration.observe import DetectHands
from halo_calibration.scripted.run import ScriptedCalibration
from halo_calibration.scripted.script import read_script
from halo_calibration.solvers.touch import StateValues
from halo_calibration.steps import STEPS, Change, Setup, require
from halo_calibration.steps.camera import MAP, CameraReport
from halo_calibration.steps.session import Session
from halo_service.app.calibration_ui.place import PLACED, WAYS, PlaceRequest, place
from halo_service.app.calibration_ui.terminal import Terminal
from halo_service.app.calibration_ui.verdict import step_line
from halo_service.app.hand_detector import HandDetector
from halo_service.app.sources import decide, is_sim, open_source
from halo_service.app.virtual_user.user import HARD_G, STATE_VALUES, VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile, StepRecord
from halo_service.profile.store import amend, exists, load, profile_path, require_fit
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.values import Side
from halo_service.virtual.sim_url import parse_sim_url

FOLLOWED_BY = {"background": ("surface",)}
"""Steps that another step does too."""


@dataclass(frozen=True, slots=True)
class CalibrateRequest:
    """What the command line asks for."""

    step: str | None = None
    """One step; None: all that are missing."""
    script: Path | None = None
    state_values: StateValues = StateValues()  # noqa: RUF009 - frozen, so one default serves all
    side: Side = Side.UNKNOWN
    base: str = "auto"
    """Base model: a file, `none`, or `auto` for the camera's own."""
    place: PlaceRequest = field(default_factory=PlaceRequest)
    """How surface, projector and anchor are found."""


MakeTerminal = Callable[[Callable[[Prompt], None] | None], Terminal]


def calibrate(
    settings: Settings, request: CalibrateRequest, terminal: MakeTerminal = Terminal
) -> Path:
    """Run one step or all that are missing; return the profile's folder.

    `terminal` makes what prompts, of what makes a virtual user follow.
    """
    if not settings.profile:
        raise UserError("calibrate: name a new or existing profile: --profile desk")
    if request.place.by is not None and request.step not in WAYS:
        raise UserError(
            f"calibrate: --by needs a step, {' or '.join(WAYS)}: "
            f"halo calibrate surface --by {request.place.by}"
        )
    folder = profile_path(settings.profile)
    with ExitStack() as stack:
        saved = load(folder) if exists(folder) else None
        source = source_for(settings, request, saved)
        stack.callback(source.close)
        if saved is not None and request.script is None:
            require_fit(saved, source.camera)
        setup = setup_for(settings, request, folder, source)
        detector_for = detectors_for(source, settings, stack)
        if request.script is not None:
            _by_script(setup, source, detector_for, request.script, folder)
        else:
            _guided(setup, source, detector_for, request, folder, terminal)
        left = missing(load(folder) if exists(folder) else None)
        say = Terminal(None).say
        say(f"Still missing: {', '.join(left)}." if left else _next_step(settings))
    return folder


def _guided(
    setup: Setup,
    source: Source,
    detector_for: Callable[[Profile | None], DetectHands],
    request: CalibrateRequest,
    folder: Path,
    make_terminal: MakeTerminal,
) -> None:
    terminal = make_terminal(source.follow if isinstance(source, VirtualUser) else None)
    guided = GuidedCalibration(setup, Session(source), terminal, detector_for)
    profile = load(folder) if exists(folder) else None
    todo = [request.step] if request.step else missing(profile)
    if not todo:
        terminal.say(f"{folder} is complete; name a step to do it again, e.g. halo calibrate touch")
        return
    terminal.say(f"Calibrating {folder}: {', '.join(todo)}.")
    if isinstance(source, VirtualUser):
        terminal.say("There is no camera, so a virtual user follows the prompts.")
    for name in todo:
        if name == "camera":
            report = guided.camera()
            for line in camera_lines(report, setup.date):
                terminal.say(line)
            if profile is not None:
                amend(folder, with_record(name, report.record(setup.date)))
            continue
        change = run_step(name, guided, source, request, profile)
        profile = amend(folder, change)
        for each in (name, *FOLLOWED_BY.get(name, ())):
            terminal.say(step_line(each, profile.steps[each]))


def run_step(
    name: str,
    guided: GuidedCalibration,
    source: Source,
    request: CalibrateRequest,
    profile: Profile | None,
    screen: Screen | None = None,
) -> Change:
    """Run one step; in a terminal and on the control page.

    `screen`: what shows the projector's pictures; None: the one that the request names. Raises
    `UserError` and its `CalibrationError`.
    """
    if name == "background":
        return guided.background()
    known = require(profile, name)
    if name in PLACED:
        return place(name, guided, source, request.place, known, screen)
    return guided.touch(known) if name == "touch" else guided.sweep(known)


def camera_lines(report: CameraReport, date: str) -> list[str]:
    """Return how the camera is placed: a map, what its marks mean, the figures and advice."""
    return [*report.map, MAP, step_line("camera", report.record(date))]


def with_record(step: str, record: StepRecord | None) -> Change:
    """Return the change that notes a step which measures nothing for the profile; None: forgets
    it."""

    def change(before: Profile | None) -> Profile:
        known = require(before, step)
        others = {name: each for name, each in known.steps.items() if name != step}
        return replace(known, steps={**others, step: record} if record else others)

    return change


def _by_script(
    setup: Setup,
    source: Source,
    detector_for: Callable[[Profile | None], DetectHands],
    script: Path,
    folder: Path,
) -> None:
    terminal = Terminal(None)
    scripted = ScriptedCalibration(setup, Session(source), detector_for, lambda words: None)
    lines = read_script(script)
    named = {line.step for line in lines}
    # A script without a background step continues the saved profile.
    before = load(folder) if exists(folder) and "background" not in named else None
    if before is not None:
        require_fit(before, source.camera)
    result = scripted.run(lines, before)
    profile = amend(folder, lambda _: result)
    for name, record in profile.steps.items():
        terminal.say(step_line(name, record))


def pilot(settings: Settings, rounds: int, round_s: float) -> Path:
    """Add the samples of one user to the base model of this camera; return its file."""
    profile = load(profile_path(settings.profile)) if settings.profile else None
    if profile is None or profile.touch is None:
        raise UserError(
            "calibrate pilot: name a profile of this place and user that has the touch step: "
            "halo calibrate touch --profile pilot1"
        )
    with ExitStack() as stack:
        source = source_for(settings, CalibrateRequest(), profile)
        stack.callback(source.close)
        require_fit(profile, source.camera)
        terminal = Terminal(source.follow if isinstance(source, VirtualUser) else None)
        setup = Setup(profile.name, source.camera, date_of(settings.source.name), settings.sensing)
        guided = GuidedCalibration(
            setup, Session(source), terminal, detectors_for(source, settings, stack)
        )
        observer = guided.observer(profile)
        rounds_done = list(pilot_rounds(guided, observer, profile, rounds=rounds, round_s=round_s))
        samples = pilot_samples(profile.surface, rounds_done)
        path = pilot_path(source.camera.serial)
        before = [read_base(path).relative] if path.is_file() else []
        write_base(merged("pilots", source.camera.serial, [*before, samples]), path)
        terminal.say(f"{path}: {len(samples)} samples added; later sweeps use them")
    return path


def missing(profile: Profile | None) -> list[str]:
    """Return the steps that a profile still needs, in order."""
    done = set() if profile is None else set(profile.steps)
    return [step for step in STEPS if step not in done and step != "surface"]


def setup_for(settings: Settings, request: CalibrateRequest, folder: Path, source: Source) -> Setup:
    """Return what stays the same over all steps."""
    virtual = isinstance(source, VirtualUser)
    return Setup(
        name=folder.name,
        camera=source.camera,
        date=date_of(settings.source.name),
        settings=settings.sensing,
        state_values=_virtual_values(request) if virtual else request.state_values,
        base=choose_base(request.base, source.camera.serial),
        side=request.side,
    )


def _virtual_values(request: CalibrateRequest) -> StateValues:
    """Return what the virtual user holds: the hard press only on request, with its own force."""
    return replace(STATE_VALUES, hard_g=None if request.state_values.hard_g is None else HARD_G)


def source_for(settings: Settings, request: CalibrateRequest, saved: Profile | None) -> Source:
    """Open the source of a guided step; for the virtual camera one with a user who follows."""
    serial = saved.camera.serial if saved else ""
    name = decide(serial) if settings.source.name == "auto" else settings.source.name
    if is_sim(name):
        # Printed boards need the full colour picture; hands are found in a smaller one.
        return VirtualUser(
            parse_sim_url(name).room, colour_times=1 if request.step in PLACED else 2
        )
    if name.startswith("recording:") and request.script is None:
        raise UserError(
            "calibrate: a recording cannot follow prompts; give its steps with --script FILE"
        )
    source = replace(settings.source, name=name, fast=name.startswith("recording:"))
    return open_source(source, serial)[0]


def date_of(source: str) -> str:
    """Return the date of the frames: now, or the date of the recording."""
    kind, _, rest = source.partition(":")
    seconds = Path(rest).stat().st_mtime if kind == "recording" else time.time()
    return datetime.fromtimestamp(int(seconds), UTC).isoformat().replace("+00:00", "Z")


def detectors_for(
    source: Source, settings: Settings, stack: ExitStack
) -> Callable[[Profile | None], DetectHands]:
    """Return what makes hand trackers; `stack` closes them."""

    def detector_for(profile: Profile | None) -> DetectHands:
        # Calibration needs one hand; the search for a second doubles the time of the tracker.
        detector = HandDetector(source.camera, profile, replace(settings.tracking, max_hands=1))
        stack.callback(detector.close)
        return detector.detect

    return detector_for


def _next_step(settings: Settings) -> str:
    source = settings.source.name
    # This scenario ends after the steps, and its finger with it.
    source = source.replace("sim:calibration", "sim:demo", 1)
    shown = "" if source == "auto" or source.startswith("recording:") else f" --source {source}"
    return f"Done. Use it with: halo serve{shown} --profile {settings.profile}"
