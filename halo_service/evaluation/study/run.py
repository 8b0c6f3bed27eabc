"""Runs the study in a pool of processes: each user is calibrated, then does each task.

Rule: each recording is stored as soon as it is simulated, so a run that was stopped continues where
it was. The order in which the processes finish changes no result.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from multiprocessing import connection
from typing import Any

import cv2
from filelock import Timeout

from halo_calibration.errors import CalibrationError
from halo_service.errors import UserError
from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.study.cache import RecordingCache
from halo_service.evaluation.study.calibrate import CalibratedUser, calibrate
from halo_service.evaluation.study.judge import judge
from halo_service.evaluation.study.plan import CALIBRATION, Plan, Task, User
from halo_service.evaluation.study.recording import load, restored
from halo_service.evaluation.study.sense import CachedHands, sense_all
from halo_service.sensing import SensingSettings
from halo_service.virtual.room import Room
from halo_service.virtual.sim_url import parse_sim_url

SIMULATE_MS, SENSE_MS, CALIBRATE_S = 30.0, 2.0, 9.0
"""Cost of simulating and tracking a frame once, of sensing it and of calibrating a user for each
method: for the progress bar, measured on a slow core."""


@dataclass(frozen=True, slots=True)
class StudyRequest:
    """What to run."""

    plan: Plan
    methods: tuple[str, ...]
    cache: RecordingCache
    settings: SensingSettings
    jobs: int


Progress = Callable[[float], None]
"""Receives seconds of work that are done."""


def work_s(request: StudyRequest) -> float:
    """Estimate the seconds of one core's work."""
    return sum(
        _work_s(request, user, task)
        for user, tasks in request.plan.items()
        for task in (CALIBRATION, *tasks)
    )


def run(request: StudyRequest, progress: Progress) -> tuple[Result, ...]:
    """Simulate what the cache lacks, calibrate, sense and score; results in the plan's order.

    Raises `UserError` where the cache cannot be written or a process was killed.
    """
    done: dict[tuple[User, str], tuple[Result, ...]] = {}
    try:
        with request.cache.exclusive(), _pool(request.jobs) as pool:
            _work_through(request, pool, done, progress)
    except BrokenProcessPool as error:
        raise UserError(
            "a process of the evaluation was killed, perhaps because memory ran out: run the same "
            "command again, it continues where it was; --jobs 1 needs the least memory"
        ) from error
    except Timeout as error:
        raise UserError(
            f"another run is writing to {request.cache.folder}: wait for it to end, or choose "
            f"another folder with --cache"
        ) from error
    except OSError as error:
        raise UserError(
            f"the recordings cannot be stored in {request.cache.folder} "
            f"({error.strerror or error}); free some space, or choose another folder with --cache"
        ) from error
    return tuple(
        result
        for user, tasks in request.plan.items()
        for task in tasks
        for result in done[user, task.name]
    )


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Open a pool of processes; all of them end with it, whatever ends the work."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=_begin)
    try:
        yield pool
    finally:
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()  # all is done, or the rest is no longer needed
        pool.shutdown(cancel_futures=True)


def _work_through(
    request: StudyRequest,
    pool: ProcessPoolExecutor,
    done: dict[tuple[User, str], tuple[Result, ...]],
    progress: Progress,
) -> None:
    """Submit the work: a user's tasks once that user is calibrated."""
    costs = {
        (user, task): _work_s(request, user, task)
        for user, tasks in request.plan.items()
        for task in (CALIBRATION, *tasks)
    }
    users = iter(request.plan)
    pending: dict[Future[Any], tuple[User, Task]] = {}
    while True:
        # One user more than processes: profiles are large, so users are finished before new ones.
        for user in islice(users, max(0, request.jobs + 1 - len(pending))):
            pending[pool.submit(_calibrate, request, user)] = user, CALIBRATION
        if not pending:
            return
        for future in wait(pending, return_when=FIRST_COMPLETED).done:
            user, task = pending.pop(future)
            outcome = future.result()
            progress(costs[user, task])
            if task is not CALIBRATION:
                done[user, task.name] = outcome
                continue
            for each in request.plan[user]:
                pending[pool.submit(_perform, request, user, each, outcome)] = user, each


def _work_s(request: StudyRequest, user: User, task: Task) -> float:
    room, methods = parse_sim_url(user.source(CALIBRATION)).room, len(request.methods)
    frames = task.seconds * room.camera().fps
    simulate_s = 0.0 if request.cache.has(user, task) else frames * SIMULATE_MS / 1e3
    if task == CALIBRATION:
        return simulate_s + methods * CALIBRATE_S
    return simulate_s + methods * frames * SENSE_MS / 1e3


def _calibrate(request: StudyRequest, user: User) -> CalibratedUser:
    methods = [METHODS[name] for name in request.methods]
    try:
        request.cache.ensure(user, CALIBRATION)
    except CalibrationError as refused:  # the empty table itself cannot be used
        return CalibratedUser(None, {}, dict.fromkeys(request.methods, str(refused)))
    camera = parse_sim_url(user.source(CALIBRATION)).room.camera()
    return calibrate(request.cache.calibration(user), camera, methods, request.settings)


def _subject(user: User, room: Room) -> Subject:
    """Describe the user by what the breakdown splits by."""
    return Subject(
        user.name, user.seed, user.material, room.curve.family, halo=room.curve.shape,
        skin_offset_mm=room.user.skin_offset_mm, curl=room.user.curl,
        height_mm=room.camera_height_mm, mode=room.mode, device=room.device,
    )  # fmt: skip


def _perform(
    request: StudyRequest, user: User, task: Task, calibrated: CalibratedUser
) -> tuple[Result, ...]:
    """Sense and score one recording with all methods that are calibrated for the user."""
    # The room is the same in all tasks; the task's own source may need a label file that is gone.
    room = parse_sim_url(user.source(CALIBRATION)).room
    subject = _subject(user, room)
    results = {
        name: Result(subject, task.name, name, None, refused)
        for name, refused in calibrated.refused.items()
    }
    if calibrated.background is not None and calibrated.profiles:
        request.cache.ensure(user, task)
        recording = load(request.cache.path(user, task))
        frames = (frame for frame, _ in restored(recording, calibrated.background))
        methods = [METHODS[name] for name in calibrated.profiles]
        settings = (
            replace(request.settings, fingers="all") if task.all_fingers else request.settings
        )
        published = sense_all(
            frames,
            room.camera(),
            CachedHands(recording),
            methods,
            calibrated.profiles,
            settings,
            CachedHands(recording, whole_image=True),
            task.hands,
        )
        for name, profile in calibrated.profiles.items():
            results[name] = judge(
                subject, task.name, name, published[name],
                recording.truth, recording.script, profile, settings,
            )  # fmt: skip
    return tuple(results[name] for name in request.methods)


def _begin() -> None:
    """Make a worker end with its parent, however that ends, and ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    parent = multiprocessing.parent_process()
    assert parent is not None  # a worker has one
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
