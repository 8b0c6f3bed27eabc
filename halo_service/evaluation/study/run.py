"""Runs the matrix over a pool of processes: each person is calibrated, then does each task.

Rule: what is drawn is kept at once, take by take, so a run that was ended goes on where it was.
The order in which the processes finish changes nothing in what is returned.
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

from halo_calibration.errors import Refused
from halo_service.errors import UserError
from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.study.cache import Studio
from halo_service.evaluation.study.calibrate import Calibrated, calibrate
from halo_service.evaluation.study.judge import judged
from halo_service.evaluation.study.plan import CALIBRATION, Person, Plan, Task
from halo_service.evaluation.study.recording import load, restore
from halo_service.evaluation.study.sense import Remembered, together
from halo_service.sensing import SensingSettings
from halo_service.virtual.camera import FPS, factory
from halo_service.virtual.sim_url import parse_sim_url

DRAWN_MS, SENSED_MS, CALIBRATED_S = 30.0, 2.0, 9.0
"""What a frame costs to draw and track once, a frame to sense and a person to calibrate for each
method: for the progress bar, measured on a slow core."""


@dataclass(frozen=True, slots=True)
class Order:
    """What is to be run."""

    plan: Plan
    methods: tuple[str, ...]
    studio: Studio
    settings: SensingSettings
    jobs: int


Progress = Callable[[float], None]
"""Is told seconds of work that are done."""


def work_s(order: Order) -> float:
    """Return about how many seconds of one core's work there are."""
    return sum(
        _work_s(order, person, task)
        for person, tasks in order.plan.items()
        for task in (CALIBRATION, *tasks)
    )


def run(order: Order, progress: Progress) -> tuple[Result, ...]:
    """Draw what is not kept yet, calibrate, sense and score; results in the plan's order.

    Raises `UserError` where takes cannot be kept or a process was ended from outside.
    """
    done: dict[tuple[Person, str], tuple[Result, ...]] = {}
    try:
        with order.studio.to_itself(), _pool(order.jobs) as pool:
            _conduct(order, pool, done, progress)
    except BrokenProcessPool as error:
        raise UserError(
            "a process of the bench was ended from outside, perhaps for want of memory: run the "
            "same command again, it goes on where it was; --jobs 1 needs least"
        ) from error
    except Timeout as error:
        raise UserError(
            f"another run is filling {order.studio.folder}: wait for it to end, or choose another "
            f"place with --keep"
        ) from error
    except OSError as error:
        raise UserError(
            f"the takes cannot be kept in {order.studio.folder} ({error.strerror or error}); "
            f"free some space, or choose another place with --keep"
        ) from error
    return tuple(
        result
        for person, tasks in order.plan.items()
        for task in tasks
        for result in done[person, task.name]
    )


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of processes; none of them is left behind, whatever ends the work."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=_begin)
    try:
        yield pool
    finally:
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()  # all is done, or nothing of what is under way is wanted
        pool.shutdown(cancel_futures=True)


def _conduct(
    order: Order,
    pool: ProcessPoolExecutor,
    done: dict[tuple[Person, str], tuple[Result, ...]],
    progress: Progress,
) -> None:
    """Hand out the work: a person's tasks when she is calibrated."""
    costs = {
        (person, task): _work_s(order, person, task)
        for person, tasks in order.plan.items()
        for task in (CALIBRATION, *tasks)
    }
    people = iter(order.plan)
    pending: dict[Future[Any], tuple[Person, Task]] = {}
    while True:
        # One ahead of the processes: profiles are large, and who is begun is best finished first.
        for person in islice(people, max(0, order.jobs + 1 - len(pending))):
            pending[pool.submit(_prepare, order, person)] = person, CALIBRATION
        if not pending:
            return
        for future in wait(pending, return_when=FIRST_COMPLETED).done:
            person, task = pending.pop(future)
            outcome = future.result()
            progress(costs[person, task])
            if task is not CALIBRATION:
                done[person, task.name] = outcome
                continue
            for each in order.plan[person]:
                pending[pool.submit(_perform, order, person, each, outcome)] = person, each


def _work_s(order: Order, person: Person, task: Task) -> float:
    frames, methods = task.seconds * FPS, len(order.methods)
    drawn_s = 0.0 if order.studio.has(person, task) else frames * DRAWN_MS / 1e3
    if task == CALIBRATION:
        return drawn_s + methods * CALIBRATED_S
    return drawn_s + methods * frames * SENSED_MS / 1e3


def _prepare(order: Order, person: Person) -> Calibrated:
    methods = [METHODS[name] for name in order.methods]
    try:
        order.studio.provide(person, CALIBRATION)
    except Refused as refused:  # the empty table itself is no good
        return Calibrated(None, {}, dict.fromkeys(order.methods, str(refused)))
    return calibrate(order.studio.of(person), methods, order.settings)


def _perform(order: Order, person: Person, task: Task, known: Calibrated) -> tuple[Result, ...]:
    """Sense and score one take, by all methods that know the person."""
    # The person's own over all tasks; a kept take of labels may have outlived its label file.
    curve = parse_sim_url(person.source(CALIBRATION)).room.curve
    subject = Subject(person.name, person.seed, person.material, curve.family)
    results = {
        name: Result(subject, task.name, name, None, refused)
        for name, refused in known.refused.items()
    }
    if known.background is not None and known.profiles:
        order.studio.provide(person, task)
        kept = load(order.studio.path(person, task))
        captures = (restore(capture, known.background)[0] for capture in kept.captures)
        methods = [METHODS[name] for name in known.profiles]
        settings = replace(order.settings, fingers="all") if task.all_fingers else order.settings
        told = together(captures, factory(), Remembered(kept), methods, known.profiles, settings)
        truth, script = kept.truth, kept.script
        for name, profile in known.profiles.items():
            results[name] = judged(
                subject, task.name, name, told[name], truth, script, profile, settings
            )
    return tuple(results[name] for name in order.methods)


def _begin() -> None:
    """Make a worker one that ends with its parent, however that ends, and Ctrl-C is not its."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    parent = multiprocessing.parent_process()
    assert parent is not None  # a worker has one
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
