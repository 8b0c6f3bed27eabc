"""The whole way: doctor, placement, calibration, session, report."""

from __future__ import annotations

import json
import platform
import shutil
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from halo_calibration.guided.guide import PROMPTS, Prompt
from halo_calibration.solvers.touch import StateValues
from halo_calibration.steps.camera import LOOK_S, CameraReport, camera_report
from halo_calibration.steps.session import Session
from halo_service.app.calibration_ui.calibrate import (
    CalibrateRequest,
    calibrate,
    camera_lines,
    missing,
    source_for,
)
from halo_service.app.calibration_ui.place import PlaceRequest
from halo_service.app.calibration_ui.terminal import Terminal
from halo_service.app.doctor import examine
from halo_service.app.evaluation_ui.guided import require_crosses
from halo_service.app.first_light.announce import PAGE, Announcer
from halo_service.app.first_light.plan import PlanOptions, tasks_of
from halo_service.app.first_light.report import Account, report_page
from halo_service.app.first_light.sensed import Sensed
from halo_service.app.first_light.session import Cutter, Followed, follow_tasks
from halo_service.app.hand_detector import HandDetector, model_for
from halo_service.app.sources import decide, is_sim
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.evaluation.metrics.result import Subject
from halo_service.evaluation.report.select import RECORDING as TASK
from halo_service.evaluation.study.judge import judge
from halo_service.files import appearing
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import exists, load, profile_path, require_fit
from halo_service.runtime.method import OURS
from halo_service.settings import Settings
from halo_service.values import Frame

RECORDING, SCRIPT, REPORT, COPY = "first-light.mkv", "first-light.json", "report.html", "profile"
MOST_MB = 200
"""A recording that is to be sent back stays below."""


@dataclass(frozen=True, slots=True)
class FirstLightRequest:
    """What the command line asks for."""

    folder: Path
    plan: PlanOptions = field(default_factory=PlanOptions)
    state_values: StateValues = StateValues()  # noqa: RUF009 - frozen
    sound: bool = True


def first_light(settings: Settings, request: FirstLightRequest) -> Path:
    """Go the whole way; return the path of the report.

    Raises `UserError` where something that is needed is missing, or the folder has a report.
    """
    if not settings.profile:
        raise UserError("first-light: name a new or existing profile: --profile desk")
    if settings.source.name.startswith("recording:"):
        raise UserError(
            "first-light: a recording cannot follow prompts; name a camera, or "
            "--source sim:calibration"
        )
    settings = _decided(settings)
    _require_healthy(settings)
    folder = _folder(request.folder)
    with ExitStack() as stack:
        announcer = Announcer(_say, folder / PAGE, None, request.sound)
        stack.callback(announcer.close)
        _say(f"Prompts in large letters: open {folder / PAGE} in a browser.")
        camera = _placement(settings, announcer)
        profile = _calibrated(settings, request, announcer)
        followed, sensed, source_facts = _session(settings, request, profile, announcer, folder)
    result = judge(
        Subject("first light"), TASK, OURS.name, sensed.published, None,
        followed.live_lines, profile, settings.sensing,
    )  # fmt: skip
    _copy_profile(settings, folder)
    account = Account(
        _facts(settings, source_facts, followed),
        camera,
        profile,
        (result,),
        followed.missed,
        sensed.lost_share,
        request.plan.coins,
        source_facts["source"] == "virtual",
        _files(folder),
    )
    with appearing(folder / REPORT) as file:
        file.write(report_page(account).encode())
    return folder / REPORT


def _decided(settings: Settings) -> Settings:
    """Decide once what `auto` means, so that each step has the same camera."""
    if settings.source.name != "auto":
        return settings
    saved = _saved(settings)
    name = decide(saved.camera.serial if saved else "")
    return replace(settings, source=replace(settings.source, name=name))


def _say(words: str) -> None:
    print(words, file=sys.stderr)


def _folder(folder: Path) -> Path:
    if (folder / RECORDING).exists():
        raise UserError(f"first-light: {folder} has a session already; name another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"first-light: {folder} cannot be created ({error.strerror}); name another folder"
        ) from error
    return folder


def _require_healthy(settings: Settings) -> None:
    model_for(settings.tracking)  # downloads it if needed
    # The profile is calibrated below.
    findings = [each for each in examine(settings) if each.what not in ("profile", "base model")]
    bad = [each for each in findings if not each.good and not each.optional]
    if bad:
        words = "; ".join(filter(None, (bad[0].state, bad[0].remedy)))
        raise UserError(f"first-light: {bad[0].what}: {words}")


class SpokenTerminal(Terminal):
    """A terminal that also speaks each prompt."""

    def __init__(self, follow: Callable[[Prompt], None] | None, announcer: Announcer) -> None:
        """`follow`: see `Terminal`."""
        super().__init__(follow)
        self._announcer = announcer

    def prompt(self, prompt: Prompt) -> None:
        """Print and speak what to do now."""
        super().prompt(prompt)
        self._announcer.speak(prompt.words)


def _placement(settings: Settings, announcer: Announcer) -> CameraReport:
    """Look at the empty table."""
    saved = _saved(settings)
    with closing(source_for(settings, CalibrateRequest(), saved)) as source:
        announcer.prompt(PROMPTS["background"])
        if isinstance(source, VirtualUser):
            source.follow(PROMPTS["background"])
        report = camera_report(list(Session(source).lasting(LOOK_S, "camera")), source.camera)
    for line in camera_lines(report, _now()):
        announcer.say(line)
    return report


def _calibrated(settings: Settings, request: FirstLightRequest, announcer: Announcer) -> Profile:
    """Do the steps that are missing; the surface by the printed sheet, so the crosses are known."""
    base = CalibrateRequest(state_values=request.state_values)

    def terminal(follow: Callable[[Prompt], None] | None) -> Terminal:
        return SpokenTerminal(follow, announcer)

    for step in missing(_saved(settings)):
        calibrate(settings, replace(base, step=step), terminal)
        if step == "background" and not is_sim(settings.source.name):
            by_sheet = replace(base, step="surface", place=PlaceRequest(by="markers"))
            calibrate(settings, by_sheet, terminal)
    profile = load(profile_path(settings.profile))
    require_crosses(profile)
    return profile


def _saved(settings: Settings) -> Profile | None:
    folder = profile_path(settings.profile)
    return load(folder) if exists(folder) else None


def _session(
    settings: Settings,
    request: FirstLightRequest,
    profile: Profile,
    announcer: Announcer,
    folder: Path,
) -> tuple[Followed, Sensed, dict[str, str]]:
    """Record the session; return what was done, what was sensed meanwhile, and the source."""
    with ExitStack() as stack:
        source = source_for(settings, CalibrateRequest(), profile)
        stack.callback(source.close)
        require_fit(profile, source.camera)
        if isinstance(source, VirtualUser):
            announcer.follow = source.follow
        detector = HandDetector(source.camera, profile, replace(settings.tracking, max_hands=1))
        stack.callback(detector.close)
        sensed = Sensed(source, profile, detector.detect, settings)
        frames = sensed.frames()
        recorder = stack.enter_context(
            Recorder(folder / RECORDING, source.camera, fps=source.camera.fps, colour=False)
        )
        cutter = Cutter(profile, next(frames))
        assert profile.touch is not None  # `require_crosses` wants the touch states
        followed = follow_tasks(
            tuple(tasks_of(profile.surface, request.plan)),
            frames,
            sensed.see,
            announcer,
            lambda frame: _write(recorder, cutter.cut(frame)),
            profile.touch.touch.raw,
        )
        with appearing(folder / SCRIPT) as file:
            file.write((json.dumps(followed.lines, indent=1) + "\n").encode())
        facts = {
            "source": source.kind,
            "camera": source.camera.serial,
            "mode": source.camera.depth_mode,
        }
    return followed, sensed, facts


def _write(recorder: Recorder, frame: Frame) -> None:
    recorder.write(frame)


def _copy_profile(settings: Settings, folder: Path) -> None:
    shutil.copytree(profile_path(settings.profile), folder / COPY, dirs_exist_ok=True)


def _facts(settings: Settings, source: dict[str, str], followed: Followed) -> dict[str, str]:
    return {
        "date": _now(),
        "camera": f"{source['camera']}, {source['mode']} ({source['source']})",
        "profile": settings.profile,
        "halo-service": version("halo-service"),
        "system": f"{platform.system()} on {platform.machine()}",
        "evaluated": _evaluated([line["step"] for line in followed.lines]),
        "recorded": f"{followed.frames} frames in which something was done",
    }


def _evaluated(steps: list[str]) -> str:
    touches, heights, forces = (steps.count(each) for each in ("target", "hover", "pressure"))
    return f"{touches} touches, {heights} heights, {forces} forces"


def _now() -> str:
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")


def _files(folder: Path) -> dict[str, str]:
    size_mb = (folder / RECORDING).stat().st_size / 1e6
    over = "" if size_mb < MOST_MB else f" (planned: {MOST_MB} MB)"
    return {
        RECORDING: f"depth and infrared near the crosses, {size_mb:.0f} MB{over}: send it",
        SCRIPT: "what the prompts requested, and when: send it",
        COPY: "the calibration: send it",
        REPORT: "this page: send it",
    }
