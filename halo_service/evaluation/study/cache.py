"""Draws and tracks one virtual person at one table, once: the takes that all methods read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from halo_calibration.solvers.background import solve_background
from halo_calibration.solvers.plane import solve_plane, surface_from_view
from halo_service.evaluation.study.plan import CALIBRATION, Person, Task
from halo_service.evaluation.study.recording import (
    Capture,
    Kept,
    Line,
    keep,
    keep_whole,
    load,
    made_of,
    reach_of,
    restore,
    save,
)
from halo_service.files import folder_lock
from halo_service.geometry.camera import Camera
from halo_service.profile import Background, Profile
from halo_service.values import Frame, Tracked
from halo_service.virtual.camera import factory
from halo_service.virtual.offline import Take
from halo_service.virtual.scenarios.calibration import BACKGROUND_S
from halo_service.virtual.sim_url import parse_sim_url

LONGEST = 1.5
"""A task that ends after its touches has ended after so many times what it should take."""

Look = Callable[[Frame], Tracked]
LookWith = Callable[[Camera, Profile | None, int], AbstractContextManager[Look]]
"""A hand tracker for a camera, over a profile where it is known, for that many hands."""

TAKES_VERSION = 2
"""Grows when the virtual Kinect, the hand tracker's picture or what is kept of a take changes in
what it gives. A number that somebody raises on purpose: a hash of the sources would throw hours of
drawing away for a comment."""
TAIL_S = 0.5
"""A take goes on so long after its last touch, that a method may still say that it ended; the
next touch comes later than that."""


@dataclass(frozen=True, slots=True)
class Studio:
    """Where takes are made and kept. Workers are handed one, so it can be pickled."""

    folder: Path
    look_with: LookWith
    tracker: str
    """Names the hand tracker and its model: other hands are another take."""
    draws: bool = True
    """False: takes are read as they lie there, however they were made."""

    @contextmanager
    def to_itself(self) -> Iterator[None]:
        """Let nobody else fill the folder meanwhile; what killed runs left half-written goes.

        Raises OSError where the folder cannot be written, or another run is filling it.
        """
        if not self.draws:
            yield
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        with folder_lock(self.folder):
            for left in self.folder.glob("*/.*.part"):
                left.unlink()
            yield

    def of(self, person: Person) -> Path:
        """Return the folder of one person's takes."""
        return self.folder / person.name

    def path(self, person: Person, task: Task) -> Path:
        """Return the file of one take."""
        return self.of(person) / f"{task.name}.npz"

    def made(self, person: Person, task: Task) -> str:
        """Name all that a take depends on; a kept take of another name is made anew."""
        until = f"{task.touches} touches" if task.touches else f"{task.seconds:g} s"
        return (
            f"takes {TAKES_VERSION}, {person.source(task)}, {'whole' if task.ends else until}, "
            f"hands {task.hands}, {self.tracker}"
        )

    def has(self, person: Person, task: Task) -> bool:
        """Say whether a take is there that need not be made anew."""
        if not self.draws:
            return self.path(person, task).is_file()
        try:
            return made_of(self.path(person, task)) == self.made(person, task)
        except (OSError, ValueError):
            return False  # not there, or damaged: it is made anew

    def provide(self, person: Person, task: Task) -> None:
        """Draw and track a take that is not there yet. Raises OSError where it cannot be kept."""
        if self.has(person, task):
            return
        assert self.draws  # who asks for kept takes alone asks for those that are there
        draw = _calibration if task == CALIBRATION else _task
        save(self.path(person, task), draw(self, person, task), self.made(person, task))


def background_of(folder: Path) -> Background:
    """Return the empty surface that the calibration in a folder began with."""
    kept = load(folder / f"{CALIBRATION.name}.npz")
    return solve_background([frame.depth for frame in empty_frames(kept)])


def profile_of_table(name: str, background: Background) -> Profile:
    """Return what the empty surface alone tells. Raises `Refused` where it is no plane."""
    camera = factory()
    surface = surface_from_view(solve_plane(background, camera))
    return Profile(name, camera, surface, background, None, 1)


def empty_frames(kept: Kept) -> Iterator[Frame]:
    """Yield the frames of a calibration that were kept whole."""
    first_us = kept.captures[0].time_us
    _, _, width, height = kept.captures[0].box
    shape = (height, width)
    nothing = Background(
        np.zeros(shape, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.bool_)
    )
    for capture in kept.captures:
        if _is_empty(capture.time_us, first_us):
            yield restore(capture, nothing)[0]


def _is_empty(time_us: int, first_us: int) -> bool:
    """Say whether a calibration's frame is from before anybody came."""
    return time_us - first_us < 1e6 * BACKGROUND_S


def _calibration(studio: Studio, person: Person, task: Task) -> Kept:
    """Draw the calibration, on whose empty surface the other tasks stand."""
    take = _drawn(person, task)
    truth: list[Line] = []
    frames = _frames(take, task, truth)
    captures: list[Capture] = []
    empty: list[Frame] = []
    with studio.look_with(take.camera, None, task.hands) as look:
        for frame in frames:
            if empty and not _is_empty(frame.time_us, empty[0].time_us):
                break
            empty.append(frame)
            captures.append(keep_whole(frame, look(frame)))
    background = solve_background([each.depth for each in empty])
    captures += _captures(studio, person, task, chain((frame,), frames), background)
    return Kept(tuple(captures), tuple(truth), tuple(take.script()))


def _task(studio: Studio, person: Person, task: Task) -> Kept:
    """Draw one task in the room whose calibration is kept."""
    background = background_of(studio.of(person))
    take = _drawn(person, task)
    truth: list[Line] = []
    frames = _frames(take, task, truth)
    captures = tuple(_captures(studio, person, task, frames, background))
    return Kept(captures, tuple(truth), tuple(take.script()))


def _captures(
    studio: Studio, person: Person, task: Task, frames: Iterable[Frame], background: Background
) -> Iterator[Capture]:
    profile = profile_of_table(person.name, background)
    camera = profile.camera
    reach = reach_of(profile.surface, camera)
    with studio.look_with(camera, profile, task.hands) as look:
        for frame in frames:
            yield keep(frame, look(frame), background, reach)


def _drawn(person: Person, task: Task) -> Take:
    """Draw as the live virtual Kinect does."""
    seconds = None if task.ends else task.seconds * (LONGEST if task.touches else 1.0)
    return Take(parse_sim_url(person.source(task)), seconds, colour_times=2)


def _frames(take: Take, task: Task, truth: list[Line]) -> Iterator[Frame]:
    """Yield the frames that came until the task is done; what was true is added to `truth`."""
    touches, over_us = 0, None
    for frame, lines in take:
        truth += lines
        touches += sum("contact" in line for line in lines)
        if frame is None:
            continue
        if touches == task.touches and over_us is None:
            over_us = frame.time_us + round(1e6 * TAIL_S)
        if over_us is not None and frame.time_us > over_us:
            return
        yield frame
