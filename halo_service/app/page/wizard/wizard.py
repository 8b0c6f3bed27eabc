"""Runs the steps one at a time, each in a thread, and can undo them.

Rule: `halo_service.app.calibration_ui` and the calibration hold the steps and verdicts; here is
only what the page needs in addition.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from halo_calibration.guided.guide import GuidedCalibration
from halo_calibration.guided.projector import Screen
from halo_calibration.steps import Change
from halo_calibration.steps.session import Session
from halo_service.app import profiles
from halo_service.app.calibration_ui.calibrate import (
    FOLLOWED_BY,
    CalibrateRequest,
    camera_lines,
    detectors_for,
    missing,
    run_step,
    setup_for,
    with_record,
)
from halo_service.app.calibration_ui.verdict import WITHIN_MM, step_line
from halo_service.app.page.observer import PageObserver
from halo_service.app.page.wizard.found import found
from halo_service.app.page.wizard.page_guide import PageGuide, Stopped
from halo_service.app.page.wizard.page_screen import BothScreens, PageScreen
from halo_service.app.page.wizard.requests import STEPS, read_request
from halo_service.app.page.wizard.sources import wizard_source
from halo_service.app.page.wizard.watch import verify_touches
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.app.verification.session import landing_line, summary_lines, verify_record
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile, StepRecord
from halo_service.profile.store import amend, exists, load, profile_path, require_fit
from halo_service.runtime.error_log import ErrorLog
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.sources.switched import SwitchedSource
from halo_service.web.control_page.calls import Call
from halo_service.web.control_page.server import PageServer

log = logging.getLogger(__name__)

MOST_UNDONE = 20
DEFAULT_NAME = "desk"


@dataclass(frozen=True, slots=True)
class Verdict:
    """How the last step ended."""

    step: str
    good: bool
    text: str
    map: Sequence[str] = ()
    """Of the picture, a line a row, and what its marks mean."""
    points: Sequence[str] = ()
    """The error of each touch of a verification."""


class Wizard:
    """One set-up: the profile that is made, and the step that runs."""

    def __init__(
        self,
        settings: Settings,
        source: SwitchedSource,
        observer: PageObserver,
        reloader: ProfileReloader,
        server: PageServer,
        paused: threading.Event,
        at_start: Callable[[], str] = str,
    ) -> None:
        """`source`: of the running service; `paused`: see `LiveLoop`; `at_start`: returns the
        profile that the settings file names."""
        self._settings, self._source = settings, source
        self._observer, self._reloader, self._server = observer, reloader, server
        self._paused, self._at_start = paused, at_start
        self.screen = PageScreen(server)
        self._name = settings.profile if profiles.is_name(settings.profile) else DEFAULT_NAME
        self._before: list[tuple[str, Profile | None]] = []
        self._verdict: Verdict | None = None
        self.running = ""
        """The step that runs; empty: none."""
        self._camera: StepRecord | None = None
        """How the camera is placed, until there is a profile that stores it."""
        self._stopped = threading.Event()
        self._thread: threading.Thread | None = None

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {
            "wizard": Call(lambda request: self.state(), reads=True),
            "wizard-profile": Call(self._choose),
            "wizard-run": Call(self._run),
            "wizard-stop": Call(self._stop),
            "wizard-undo": Call(self._undo),
        }

    def close(self) -> None:
        """Stop the step that runs."""
        self._stopped.set()
        if self._thread is not None:
            self._thread.join()

    def state(self) -> dict[str, Any]:
        """Return all that the page shows."""
        folder = profile_path(self._name)
        profile, error = None, ""
        try:
            profile = load(folder) if exists(folder) else None
        except UserError as refused:
            error = str(refused)
        return {
            "kind": "wizard",
            "profile": self._name,
            "error": error,
            "exists": profile is not None,
            "in_use": self._reloader.profile.name if self._reloader.profile else "",
            "at_start": self._at_start(),
            "steps": found(profile, self._camera),
            "missing": missing(profile),
            "running": self.running,
            "verdict": self._verdict
            and {
                "step": self._verdict.step,
                "good": self._verdict.good,
                "text": self._verdict.text,
                "map": list(self._verdict.map),
                "points": list(self._verdict.points),
            },
            "can_undo": bool(self._before) and not self.running,
            "screen": list(self.screen.size_px) if self.screen.is_open else None,
            "virtual": self._source.source.kind == "virtual",
            "has_projector": profile is not None and profile.projector is not None,
        }

    def _show(self) -> None:
        state = self.state()
        self._server.post(lambda: self._server.broadcast(state))

    def _show_guide(self, guide: dict[str, Any]) -> None:
        value = {"kind": "guide", **guide}
        self._server.post(lambda: self._server.broadcast(value))

    def _choose(self, request: dict[str, Any]) -> dict[str, Any]:
        """Work on another profile, new or not."""
        self._refuse_while_running()
        name = request["name"]
        if not isinstance(name, str):
            raise UserError("name a profile")
        profiles.check_name(name)
        self._name, self._before, self._verdict = name, [], None
        return self.state()

    def _run(self, request: dict[str, Any]) -> dict[str, Any]:
        """Start a step."""
        self._refuse_while_running()
        step = request["step"]
        if step not in STEPS:
            raise UserError(f"unknown step; choose from: {', '.join(STEPS)}")
        options = read_request(step, request)
        self._stopped.clear()
        self.running, self._verdict = step, None
        self._thread = threading.Thread(
            target=self._do, args=(step, options), name="wizard", daemon=True
        )
        self._thread.start()
        return self.state()

    def _stop(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        self._stopped.set()
        return {}

    def _undo(self, request: dict[str, Any]) -> dict[str, Any]:
        """Restore the profile as it was before the last step."""
        del request
        self._refuse_while_running()
        if not self._before:
            raise UserError("there is nothing to undo")
        name, before = self._before.pop()
        folder = profile_path(name)
        if before is None:
            profiles.delete(name)
        else:
            kept = before
            amend(folder, lambda _: kept)
        self._verdict = Verdict("", True, "The last step is undone.")
        return self.state()

    def _refuse_while_running(self) -> None:
        if self.running:
            raise UserError(f"the step '{self.running}' runs; stop it first")

    def _do(self, step: str, options: CalibrateRequest) -> None:
        """Run a step in its thread."""
        errors = ErrorLog()
        verdict = Verdict(step, False, "an unexpected error; see the log")
        with errors.guard("wizard"):
            try:
                verdict = self._done(step, options)
            except Stopped:
                verdict = Verdict(step, False, "Stopped; nothing was changed.")
            except UserError as refused:
                verdict = Verdict(step, False, str(refused))
        self._verdict, self.running = verdict, ""
        log.info("set-up: %s", verdict.text)
        self._show()

    def _done(self, step: str, options: CalibrateRequest) -> Verdict:
        name, folder = self._name, profile_path(self._name)
        with ExitStack() as stack:
            source = stack.enter_context(
                wizard_source(self._source, self._observer, self._paused, step)
            )
            follow = source.follow if isinstance(source, VirtualUser) else None
            guide = PageGuide(self._show_guide, self._stopped, follow)
            self._show()
            before = load(folder) if exists(folder) else None
            if before is not None:
                require_fit(before, source.camera)
            setup = setup_for(self._settings, options, folder, source)
            if step == "verify":
                return self._verified(folder, before, source, guide, setup.date)
            detector_for = detectors_for(source, replace(self._settings, profile=name), stack)
            guided = GuidedCalibration(setup, Session(source), guide, detector_for)
            if step == "camera":
                return self._judged(folder, before, guided)
            screen = self._screen(source) if step == "projector" else None
            change = run_step(step, guided, source, options, before, screen)
        profile = self._amend(folder, before, self._with_camera(change))
        self._reloader.switch(folder)  # the service uses it at once
        lines = [
            step_line(each, profile.steps[each]) for each in (step, *FOLLOWED_BY.get(step, ()))
        ]
        return Verdict(step, True, "\n".join(lines))

    def _judged(self, folder: Path, before: Profile | None, guided: GuidedCalibration) -> Verdict:
        """Judge the camera's placement, and note it."""
        report = guided.camera()
        self._camera = record = report.record(guided.setup.date)
        if before is not None:
            self._amend(folder, before, with_record("camera", record))
        *drawn, line = camera_lines(report, guided.setup.date)
        return Verdict("camera", record.quality == "good", line, drawn)

    def _verified(
        self, folder: Path, before: Profile | None, source: Source, guide: PageGuide, date: str
    ) -> Verdict:
        """Verify touches, and note the result where it is good."""
        shown = self._screen(source)
        grid = verify_touches(before, source, shown, guide, self._settings, self._observer)
        lines, good = summary_lines(grid, WITHIN_MM)
        record = verify_record(grid, date) if good else None
        if record is not None or (before is not None and "verify" in before.steps):
            self._amend(folder, before, with_record("verify", record))
        points = [landing_line(grid, each) for each in grid.landings]
        return Verdict("verify", good, "\n".join(lines), points=points)

    def _with_camera(self, change: Change) -> Change:
        """Return a change that also stores how the camera is placed, once there is a profile."""
        record = self._camera

        def both(before: Profile | None) -> Profile:
            after = change(before)
            return after if record is None else with_record("camera", record)(after)

        return both

    def _amend(self, folder: Path, before: Profile | None, change: Change) -> Profile:
        """Change the profile so that it can be undone."""
        profile = amend(folder, change)
        self._before = [*self._before, (folder.name, before)][-MOST_UNDONE:]
        return profile

    def _screen(self, source: Source) -> Screen:
        if isinstance(source, VirtualUser):
            return BothScreens(source.project, source.projector_px, self.screen)
        self.screen.size_px  # noqa: B018 - raises where no page is open
        return self.screen
