"""`halo evaluate`: the study on virtual people, or a recording with its truth."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

from halo_service.app.hand_detector import HandDetector, model_for
from halo_service.app.progress import progress
from halo_service.app.service.fit_watcher import watched
from halo_service.app.sources import open_recording
from halo_service.errors import UserError
from halo_service.evaluation.methods import METHODS, NEEDS_NO_STATES, READS_PROFILE
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.study import plan as study
from halo_service.evaluation.study.cache import RecordingCache
from halo_service.evaluation.study.judge import judge_recording, read_lines
from halo_service.evaluation.study.plan import Plan, Task, User
from halo_service.evaluation.study.run import StudyRequest, run, work_s
from halo_service.evaluation.study.simulate import Tracker
from halo_service.files import cache_folder
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.profile.store import load as load_profile
from halo_service.profile.store import profile_path, require_fit, require_touch
from halo_service.settings import Settings, TrackingSettings
from halo_service.values import Frame, Tracked
from halo_service.virtual.camera import MODES
from halo_service.virtual.materials import MATERIALS, STUDIED
from halo_service.virtual.sim_url import parse_sim_url

ASK_H = 0.5
"""A run that takes longer begins only after a question, where somebody can answer."""


@dataclass(frozen=True, slots=True)
class StudyOptions:
    """The command line's options; empty or None: what the plan has."""

    quick: bool = False
    methods: tuple[str, ...] = ()
    users: tuple[int, ...] = ()
    materials: tuple[str, ...] = ()
    tasks: tuple[str, ...] = ()
    labels: Path | None = None
    cache: Path | None = None
    cached_only: bool = False
    jobs: int | None = None
    sensor: str | None = None
    """Of the virtual camera; None: `kind` for the quick study, else `true`."""
    heights_mm: tuple[float, ...] = ()
    """Of the virtual camera above the table; empty: the user's own."""
    modes: tuple[str, ...] = ()
    """Its depth modes; empty: the user's own."""


def known_methods(wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the names of methods; raises `UserError` for an unknown one."""
    return study.choose(wanted, tuple(METHODS), "method")


def evaluate(
    settings: Settings,
    options: StudyOptions,
    confirm: Callable[[float], bool] = lambda hours: True,
) -> tuple[Result, ...]:
    """Run the study, with a progress bar; raises `UserError` for a wrong request.

    `confirm` is asked before a run that takes longer than `ASK_H`.
    """
    tracker = _tracker(settings.tracking)
    cache = RecordingCache(
        options.cache or cache_folder() / "recordings",
        partial(looking, settings.tracking),
        tracker,
        not options.cached_only,
    )
    methods = known_methods(options.methods or tuple(METHODS))
    request = StudyRequest(
        _plan(options, cache), methods, cache, settings.sensing, _jobs(options.jobs)
    )
    hours = work_s(request) / 3600.0 / request.jobs
    if hours > ASK_H and not confirm(hours):
        raise UserError("evaluate: nothing was run; 'halo evaluate --quick' takes five minutes")
    with progress("study", work_s(request)) as bar:
        return run(request, bar.advance)


@dataclass(frozen=True, slots=True)
class RecordingOptions:
    """A recording to evaluate."""

    recording: Path
    truth: Path | None
    """None: unknown; the script says what the user did."""
    script: Path | None
    methods: tuple[str, ...]
    """Empty: those that read the profile as it is; `paper` needs levels of its own signal."""


def evaluate_recording(settings: Settings, options: RecordingOptions) -> tuple[Result, ...]:
    """Compare a recording with its truth or script; raises `UserError` if one is wrong."""
    if options.truth is None and options.script is None:
        raise UserError("evaluate: a recording needs --truth T.jsonl or --script S.json")
    if not settings.profile:
        raise UserError("evaluate: name the profile of the recording: --profile P")
    profile = load_profile(profile_path(settings.profile))
    methods = known_methods(options.methods or READS_PROFILE)
    truth = read_lines(options.truth, "truth") if options.truth else None
    script = read_lines(options.script, "script") if options.script else ()
    if not set(methods) <= set(NEEDS_NO_STATES):
        require_touch(profile)
    with closing(open_recording(options.recording)) as source:
        require_fit(profile, source.camera)
        with (
            closing(HandDetector(source.camera, profile, settings.tracking)) as detector,
            progress(f"evaluating {options.recording.name}") as bar,
        ):
            detect = watched(detector.detect, profile)

            def track(frame: Frame) -> Tracked:
                bar.advance()
                return detect(frame)

            return judge_recording(
                source,
                options.recording.stem,
                track,
                [METHODS[name] for name in methods],
                profile,
                settings.sensing,
                truth,
                script,
            )


@contextmanager
def looking(
    tracking: TrackingSettings, camera: Camera, profile: Profile | None, hands: int
) -> Iterator[Tracker]:
    """Open a hand tracker that looks for that many hands."""
    with closing(HandDetector(camera, profile, replace(tracking, max_hands=hands))) as detector:
        yield detector.detect


def _plan(options: StudyOptions, cache: RecordingCache) -> Plan:
    materials = study.choose(options.materials or STUDIED, tuple(MATERIALS), "material")
    modes = study.choose(options.modes, tuple(MODES), "depth mode")
    if options.cached_only:
        plan = _cached(cache, options, materials)
    elif options.quick:
        plan = study.quick_plan(
            options.users or study.QUICK_USERS, materials, options.sensor or "kind"
        )
    else:
        files = () if options.labels is None else _label_files(options.labels)
        users, sensor = options.users or study.REPORTED, options.sensor or "true"
        plan = study.plan(users, materials, labels=files, sensor=sensor)
    if not options.cached_only:
        plan = study.seen_from(plan, options.heights_mm, modes)
        for user in plan:
            parse_sim_url(user.source(study.CALIBRATION))  # refuses a camera that is too high
    names = sorted({task.name for tasks in plan.values() for task in tasks})
    wanted = study.choose(options.tasks or tuple(names), tuple(names), "task")
    plan = {
        user: tuple(task for task in tasks if task.name in wanted) for user, tasks in plan.items()
    }
    return {user: tasks for user, tasks in plan.items() if tasks}


def _cached(
    cache: RecordingCache, options: StudyOptions, materials: Sequence[str]
) -> dict[User, tuple[Task, ...]]:
    """Plan only what the cache holds."""
    plan = {}
    for file in sorted(cache.folder.glob(f"*/{study.CALIBRATION.name}.npz")):
        user = study.user_of(file.parent.name)
        if user is None or not _is_wanted(user, options, materials):
            continue
        labels = sorted(file.parent.glob(f"{study.LABELS.name}-*.npz"))
        tasks = (*study.ALL_TASKS, *(replace(study.LABELS, name=each.stem) for each in labels))
        plan[user] = tuple(task for task in tasks if cache.has(user, task))
    if not plan:
        raise UserError(
            f"no cached recordings of these users and materials in {cache.folder}; leave out "
            f"--cached-only to simulate them"
        )
    return plan


def _is_wanted(user: User, options: StudyOptions, materials: Sequence[str]) -> bool:
    return (
        user.material in materials
        and options.sensor in (None, user.sensor)
        and (not options.users or user.seed in options.users)
        and (not options.heights_mm or user.height_mm in options.heights_mm)
        and (not options.modes or user.mode in options.modes)
    )


def _label_files(folder: Path) -> list[Path]:
    files = sorted(folder.glob("*.txt")) if folder.is_dir() else []
    if not files:
        raise UserError(f"no label file (*.txt) in {folder}; give --labels the folder with them")
    return files


def _jobs(wanted: int | None) -> int:
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    return wanted or cores


def _tracker(tracking: TrackingSettings) -> str:
    """Name the hand tracker by all that its results depend on."""
    model = hashlib.sha256(model_for(tracking).read_bytes()).hexdigest()[:12]
    return f"mediapipe {version('mediapipe')} {model}"
