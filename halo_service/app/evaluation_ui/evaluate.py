"""`halo evaluate`: the study on virtual people, or a recording with its truth."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

from platformdirs import user_cache_path

from halo_service.app.hand_detector import HandDetector, model_for
from halo_service.app.progress import progress
from halo_service.errors import UserError
from halo_service.evaluation.methods import AS_CALIBRATED, BY_SURFACE, METHODS
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.study import plan as matrix
from halo_service.evaluation.study.cache import Look, Studio
from halo_service.evaluation.study.judge import read_lines, recording_judged
from halo_service.evaluation.study.plan import Person, Plan, Task
from halo_service.evaluation.study.run import Order, run, work_s
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.profile.store import load as load_profile
from halo_service.profile.store import profile_path, require_fit, require_touch
from halo_service.settings import Settings, TrackingSettings
from halo_service.sources.recording import Recording
from halo_service.values import Frame, Tracked
from halo_service.virtual.materials import MATERIALS, STUDIED


@dataclass(frozen=True, slots=True)
class StudyRequest:
    """What the command line asks for; empty or None: what the matrix has."""

    quick: bool = False
    methods: tuple[str, ...] = ()
    users: tuple[int, ...] = ()
    materials: tuple[str, ...] = ()
    tasks: tuple[str, ...] = ()
    labels: Path | None = None
    keep: Path | None = None
    kept_only: bool = False
    jobs: int | None = None


def known_methods(wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the names of methods; raises `UserError` for one that nobody knows."""
    return matrix.chosen(wanted, tuple(METHODS), "method")


def evaluate(settings: Settings, request: StudyRequest) -> tuple[Result, ...]:
    """Run the study, with a progress bar; raises `UserError` for what cannot be run."""
    tracker = _tracker(settings.tracking)
    studio = Studio(
        request.keep or user_cache_path("halo-service", appauthor=False) / "takes",
        partial(looking, settings.tracking),
        tracker,
        not request.kept_only,
    )
    methods = known_methods(request.methods or tuple(METHODS))
    order = Order(_plan(request, studio), methods, studio, settings.sensing, _jobs(request.jobs))
    with progress("study", work_s(order)) as bar:
        return run(order, bar.advance)


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """A recording to judge."""

    recording: Path
    truth: Path | None
    """None: nobody knows it, and the script says what was asked of the person."""
    script: Path | None
    methods: tuple[str, ...]
    """Empty: those that the profile serves; another would stand there with levels of our signal."""


def evaluate_recording(settings: Settings, request: RecordingRequest) -> tuple[Result, ...]:
    """Judge a recording by its truth or its script; raises `UserError` where one is none."""
    if request.truth is None and request.script is None:
        raise UserError("evaluate RECORDING needs --truth T.jsonl, or --script S.json without it")
    if not settings.profile:
        raise UserError("evaluate: name the profile that goes with the recording: --profile P")
    profile = load_profile(profile_path(settings.profile))
    methods = known_methods(request.methods or AS_CALIBRATED)
    truth = read_lines(request.truth, "truth") if request.truth else None
    script = read_lines(request.script, "script") if request.script else ()
    if not set(methods) <= set(BY_SURFACE):
        require_touch(profile)
    with closing(Recording(request.recording, realtime=False, loop=False)) as source:
        require_fit(profile, source.camera)
        with (
            closing(HandDetector(source.camera, profile, settings.tracking)) as eyes,
            progress(f"evaluating {request.recording.name}") as bar,
        ):

            def look(frame: Frame) -> Tracked:
                bar.advance()
                return eyes.look(frame)

            return recording_judged(
                source,
                request.recording.stem,
                look,
                [METHODS[name] for name in methods],
                profile,
                settings.sensing,
                truth,
                script,
            )


@contextmanager
def looking(
    tracking: TrackingSettings, camera: Camera, profile: Profile | None, hands: int
) -> Iterator[Look]:
    """Give a hand tracker that looks for so many hands."""
    with closing(HandDetector(camera, profile, replace(tracking, max_hands=hands))) as eyes:
        yield eyes.look


def _plan(request: StudyRequest, studio: Studio) -> Plan:
    materials = matrix.chosen(request.materials or STUDIED, tuple(MATERIALS), "material")
    if request.kept_only:
        plan = _kept(studio, request.users, materials)
    elif request.quick:
        plan = matrix.quick_plan(request.users or matrix.QUICK_USERS, materials)
    else:
        files = () if request.labels is None else _label_files(request.labels)
        plan = matrix.plan(request.users or matrix.REPORTED, materials, labels=files)
    names = sorted({task.name for tasks in plan.values() for task in tasks})
    wanted = matrix.chosen(request.tasks or tuple(names), tuple(names), "task")
    plan = {
        person: tuple(task for task in tasks if task.name in wanted)
        for person, tasks in plan.items()
    }
    return {person: tasks for person, tasks in plan.items() if tasks}


def _kept(
    studio: Studio, users: Sequence[int], materials: Sequence[str]
) -> dict[Person, tuple[Task, ...]]:
    """Plan what lies in the folder, and nothing else."""
    plan = {}
    for file in sorted(studio.folder.glob(f"*/{matrix.CALIBRATION.name}.npz")):
        seed, _, material = file.parent.name.partition("-")
        if seed.isdigit() and material in materials and (not users or int(seed) in users):
            person = Person(int(seed), material)
            labels = sorted(file.parent.glob(f"{matrix.LABELS.name}-*.npz"))
            tasks = (*matrix.KNOWN, *(replace(matrix.LABELS, name=each.stem) for each in labels))
            plan[person] = tuple(task for task in tasks if studio.has(person, task))
    if not plan:
        raise UserError(
            f"no kept takes of these users and materials are in {studio.folder}; leave out "
            f"--kept-only to have them drawn"
        )
    return plan


def _label_files(folder: Path) -> list[Path]:
    files = sorted(folder.glob("*.txt")) if folder.is_dir() else []
    if not files:
        raise UserError(f"there is no label file (*.txt) in {folder}; give --labels their folder")
    return files


def _jobs(wanted: int | None) -> int:
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    return wanted or cores


def _tracker(tracking: TrackingSettings) -> str:
    """Name the hand tracker by all that makes it see what it sees."""
    model = hashlib.sha256(model_for(tracking).read_bytes()).hexdigest()[:12]
    return f"mediapipe {version('mediapipe')} {model}"
