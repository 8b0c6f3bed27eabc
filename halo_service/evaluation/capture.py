"""One virtual person at one table, drawn and tracked once: the takes that all methods read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from halo_calibration.background import solve_background
from halo_calibration.plane import solve_plane, surface_from_view
from halo_service.evaluation.kept import (
    Capture,
    Kept,
    keep,
    keep_whole,
    load,
    played,
    reach_of,
    save,
)
from halo_service.geometry.camera import Camera
from halo_service.profile import Background
from halo_service.values import Frame, Tracked
from halo_service.virtual.naming import wish
from halo_service.virtual.offline import Take
from halo_service.virtual.plays.calibration import BACKGROUND_S

Look = Callable[[Frame], Tracked]
LookWith = Callable[[Camera, Background | None, int], Look]
"""A hand tracker for a camera, over a background where it is known, for that many hands."""

CALIBRATION = "calibration"


@dataclass(frozen=True, slots=True)
class Task:
    """What a person is asked to do."""

    name: str
    scenario: str
    """Of the virtual Kinect."""
    seconds: float | None = None
    """None: until it ends by itself."""
    options: str = ""
    """As in a source's name: `noise=2`."""
    hands: int = 1
    """How many the tracker looks for."""


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody at a table."""

    seed: int
    material: str

    @property
    def name(self) -> str:
        """Of the folder."""
        return f"{self.seed}-{self.material}"

    def source(self, task: Task) -> str:
        """What the virtual Kinect is asked for."""
        more = f"&{task.options}" if task.options else ""
        return f"sim:{task.scenario}?seed={self.seed}&material={self.material}{more}"


def take_calibration(person: Person, folder: Path, look_with: LookWith) -> None:
    """Draw the calibration, whose empty surface the other tasks stand on."""
    take = _drawn(person.source(Task(CALIBRATION, CALIBRATION)), None)
    empty: list[Frame] = []
    captures: list[Capture] = []
    truth = []
    look = look_with(take.camera, None, 1)
    background: Background | None = None
    reach = (0, 0, 0, 0)
    for frame, lines in take:
        truth += lines
        if frame is None:
            continue
        if frame.time_us - captures[0].time_us < 1e6 * BACKGROUND_S if captures else True:
            empty.append(frame)
            captures.append(keep_whole(frame, look(frame)))
            continue
        if background is None:
            background = solve_background([each.depth for each in empty])
            surface = surface_from_view(solve_plane(background, take.camera))
            reach = reach_of(surface, take.camera)
            look = look_with(take.camera, background, 1)
        captures.append(keep(frame, look(frame), background, reach))
    save(folder / f"{CALIBRATION}.npz", Kept(tuple(captures), tuple(truth), tuple(take.script())))


def take_task(person: Person, task: Task, folder: Path, look_with: LookWith) -> None:
    """Draw one task in the room whose calibration is in the folder."""
    background = background_of(folder)
    take = _drawn(person.source(task), task.seconds)
    reach = reach_of(surface_from_view(solve_plane(background, take.camera)), take.camera)
    look = look_with(take.camera, background, task.hands)
    captures, truth = [], []
    for frame, lines in take:
        truth += lines
        if frame is not None:
            captures.append(keep(frame, look(frame), background, reach))
    save(folder / f"{task.name}.npz", Kept(tuple(captures), tuple(truth), tuple(take.script())))


def background_of(folder: Path) -> Background:
    """Return the empty surface that the calibration in a folder began with."""
    kept = load(folder / f"{CALIBRATION}.npz")
    return solve_background([frame.depth for frame, _ in empty_frames(kept)])


def empty_frames(kept: Kept) -> Iterator[tuple[Frame, Tracked]]:
    """Yield the frames that were kept whole."""
    first = kept.captures[0].time_us
    nothing = _nothing(kept.captures[0].box)
    whole = tuple(each for each in kept.captures if each.time_us - first < 1e6 * BACKGROUND_S)
    return played(Kept(whole, (), ()), nothing)


def _nothing(box: tuple[int, int, int, int]) -> Background:
    shape = (box[3], box[2])
    return Background(
        np.zeros(shape, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.bool_)
    )


def _drawn(source: str, seconds: float | None) -> Take:
    """Draw as the live virtual Kinect does."""
    return Take(wish(source), seconds, colour_times=2)
