"""Simulates one user doing one task, and runs the hand tracker on it: what the cache stores."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from itertools import chain, takewhile

import numpy as np

from halo_calibration.solvers.background import solve_background
from halo_calibration.solvers.plane import solve_plane, surface_from_view
from halo_service.evaluation.study.plan import Task, User
from halo_service.evaluation.study.recording import (
    Line,
    StoredFrame,
    StoredRecording,
    reach_box,
    restore,
    store,
    store_whole,
)
from halo_service.geometry.camera import Camera
from halo_service.profile import Background, Profile
from halo_service.values import Frame, Tracked
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.scenarios.calibration import background_s
from halo_service.virtual.sim_url import parse_sim_url

LONGEST = 1.5
"""A task that ends after its touches ends at the latest after this many times its usual length."""
TAIL_S = 0.5
"""A recording goes on for so long after its last touch, so that a method can report the touch's
end; the next touch comes later than that."""

Tracker = Callable[[Frame], Tracked]
OpenTracker = Callable[[Camera, Profile | None, int], AbstractContextManager[Tracker]]
"""Opens a hand tracker for a camera, with a profile where there is one, for that many hands."""


def simulate_calibration(user: User, task: Task, open_tracker: OpenTracker) -> StoredRecording:
    """Simulate the calibration; the user's other recordings need its empty surface."""
    simulation = _simulation(user, task)
    empty_us = 1e6 * background_s(parse_sim_url(user.source(task)).room)
    truth: list[Line] = []
    frames = _frames(simulation, task, truth)
    stored: list[StoredFrame] = []
    empty: list[Frame] = []
    with open_tracker(simulation.camera, None, task.hands) as track:
        for frame in frames:
            if empty and frame.time_us - empty[0].time_us >= empty_us:
                break
            empty.append(frame)
            stored.append(store_whole(frame, track(frame)))
    background = solve_background([each.depth for each in empty], [each.ir for each in empty])
    later = chain((frame,), frames)
    stored += _stored(user, task, later, background, open_tracker, simulation.camera)
    return StoredRecording(tuple(stored), tuple(truth), tuple(simulation.script()))


def simulate_task(
    user: User, task: Task, background: Background, open_tracker: OpenTracker
) -> StoredRecording:
    """Simulate one task on the surface that the calibration has seen."""
    simulation = _simulation(user, task)
    truth: list[Line] = []
    frames = _frames(simulation, task, truth)
    stored = tuple(_stored(user, task, frames, background, open_tracker, simulation.camera))
    return StoredRecording(stored, tuple(truth), tuple(simulation.script()))


def background_of(calibration: StoredRecording) -> Background:
    """Return the empty surface that a calibration begins with."""
    frames = list(empty_frames(calibration))
    return solve_background([frame.depth for frame in frames], [frame.ir for frame in frames])


def profile_of_table(name: str, background: Background, camera: Camera) -> Profile:
    """Return a profile with the empty surface alone. Raises `CalibrationError` without a plane."""
    surface = surface_from_view(solve_plane(background, camera))
    return Profile(name, camera, surface, background, None, 1)


def empty_frames(calibration: StoredRecording) -> Iterator[Frame]:
    """Yield the frames that a calibration begins with, stored whole: those without a hand."""
    whole = calibration.frames[0].box
    _, _, width, height = whole
    shape = (height, width)
    nothing = Background(
        np.zeros(shape, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.bool_)
    )
    for each in takewhile(lambda each: each.box == whole, calibration.frames):
        yield restore(each, nothing)[0]


def _stored(
    user: User,
    task: Task,
    frames: Iterable[Frame],
    background: Background,
    open_tracker: OpenTracker,
    camera: Camera,
) -> Iterator[StoredFrame]:
    profile = profile_of_table(user.name, background, camera)
    reach = reach_box(profile.surface, camera)
    with (
        open_tracker(camera, profile, task.hands) as track,
        open_tracker(camera, None, task.hands) as track_image,
    ):
        for frame in frames:
            yield store(frame, track(frame), background, reach, track_image(frame).hands)


def _simulation(user: User, task: Task) -> SimulatedRecording:
    """Simulate at the live virtual camera's quality."""
    seconds = None if task.ends else task.seconds * (LONGEST if task.touches else 1.0)
    return SimulatedRecording(parse_sim_url(user.source(task)), seconds, colour_times=2)


def _frames(simulation: SimulatedRecording, task: Task, truth: list[Line]) -> Iterator[Frame]:
    """Yield the frames until the task is done; the lines of truth are added to `truth`."""
    touches, over_us = 0, None
    for frame, lines in simulation:
        truth += lines
        touches += sum("contact" in line for line in lines)
        if frame is None:
            continue
        if touches == task.touches and over_us is None:
            over_us = frame.time_us + round(1e6 * TAIL_S)
        if over_us is not None and frame.time_us > over_us:
            return
        yield frame
