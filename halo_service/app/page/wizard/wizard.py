"""Runs the steps one at a time, each in a thread, and can undo them.

Rule: `halo_service.app.calibration_ui` and the calibration hold the steps and verdicts; here is
only what the page needs in addition.
"""

from __future__ import annotations

import logging
import threading
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from halo_calibration.guided.guide import GuidedCalibration
from halo_calibration.guided.projector import Screen
from halo_calibration.steps.session import Session
from halo_service.app import profiles
from halo_service.app.calibration_ui.calibrate import (
    FOLLOWED_BY,
    CalibrateRequest,
    detectors_for,
    missing,
    run_step,
    setup_for,
)
from halo_service.app.calibration_ui.terminal import step_line
from halo_service.app.page.observer import PageObserver
from halo_service.app.page.wizard.page_guide import PageGuide, Stopped
from halo_service.app.page.wizard.page_screen import BothScreens, PageScreen
from halo_service.app.page.wizard.requests import STEPS, read_request
from halo_service.app.page.wizard.sources import wizard_source
from halo_service.app.page.wizard.watch import judge_camera, verify_touches
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.profile.store import amend, exists, load, profile_path, require_fit
from halo_service.runtime.error_log import ErrorLog
from halo_service.settings import Settings
from halo_service.sources import Source
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


class Wizard:
    """One set-up: the profile that is made, and the step that runs."""

    def __init__(
        self,
        settings: Settings,
        source: Source,
        observer: PageObserver,
        reloader: ProfileReloader,
        server: PageServer,
        paused: threading.Event,
    ) -> None:
        """`source`: of the running service; `paused`: see `LiveLoop`."""
        self._settings, self._source = settings, source
        self._observer, self._reloader, self._server = observer, reloader, server
        self._paused = paused
        self.screen = PageScreen(server)
        self._name = settings.profile if profiles.is_name(settings.profile) else DEFAULT_NAME
        self._before: list[tuple[str, Profile | None]] = []
        self._verdict: Verdict | None = None
        self._running = ""
        self._guide_state: dict[str, Any] = {}
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
            "steps": {name: step_line(name, each) for name, each in _records(profile)},
            "qualities": {name: each.quality for name, each in _records(profile)},
            "missing": missing(profile),
            "running": self._running,
            "verdict": self._verdict
            and {
                "step": self._verdict.step,
                "good": self._verdict.good,
                "text": self._verdict.text,
            },
            "can_undo": bool(self._before) and not self._running,
            "screen": list(self.screen.size_px) if self.screen.is_open else None,
            "virtual": self._source.kind == "virtual",
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
        self._running, self._verdict = step, None
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
        if self._running:
            raise UserError(f"the step '{self._running}' runs; stop it first")

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
        self._verdict, self._running = verdict, ""
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
            if step == "camera":
                return Verdict(step, *judge_camera(source, guide))
            if step == "verify":
                shown, observer = self._screen(source), self._observer
                verified = verify_touches(before, source, shown, guide, self._settings, observer)
                return Verdict(step, *verified)
            setup = setup_for(self._settings, options, folder, source)
            detector_for = detectors_for(source, replace(self._settings, profile=name), stack)
            guided = GuidedCalibration(setup, Session(source), guide, detector_for)
            screen = self._screen(source) if step == "projector" else None
            change = run_step(step, guided, source, options, before, screen)
        profile = amend(folder, change)
        self._before = [*self._before, (name, before)][-MOST_UNDONE:]
        self._use(folder)
        lines = [
            step_line(each, profile.steps[each]) for each in (step, *FOLLOWED_BY.get(step, ()))
        ]
        return Verdict(step, True, "\n".join(lines))

    def _use(self, folder: Path) -> None:
        """Let the service use the profile at once."""
        self._reloader.switch(folder)

    def _screen(self, source: Source) -> Screen:
        if isinstance(source, VirtualUser):
            return BothScreens(source.project, source.projector_px, self.screen)
        self.screen.size_px  # noqa: B018 - raises where no page is open
        return self.screen


def _records(profile: Profile | None) -> list[tuple[str, Any]]:
    return [] if profile is None else list(profile.steps.items())
