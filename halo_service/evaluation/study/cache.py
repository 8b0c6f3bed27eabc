"""The folder of simulated recordings: each is simulated and tracked once, for all methods."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from halo_service.evaluation.study.plan import CALIBRATION, Task, User
from halo_service.evaluation.study.recording import StoredRecording, load, read_key, save
from halo_service.evaluation.study.simulate import (
    OpenTracker,
    background_of,
    simulate_calibration,
    simulate_task,
)
from halo_service.files import folder_lock

VERSION = 5
"""Grows when the virtual camera, the hand tracker's picture or the stored data change what they
give. Somebody raises it on purpose: a hash of the sources would discard hours of simulation for a
comment."""


@dataclass(frozen=True, slots=True)
class RecordingCache:
    """Where recordings are stored. Worker processes receive one, so it can be pickled."""

    folder: Path
    open_tracker: OpenTracker
    tracker: str
    """Name of the hand tracker and its model: other hands make another recording."""
    simulates: bool = True
    """False: only cached recordings are used, however they were made."""

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Let no other run write to the folder; delete what killed runs left half-written.

        Raises OSError where the folder cannot be written, or another run is writing to it.
        """
        if not self.simulates:
            yield
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        with folder_lock(self.folder):
            for left in self.folder.glob("*/.*.part"):
                left.unlink()
            yield

    def path(self, user: User, task: Task) -> Path:
        """Return the file of one recording."""
        return self.folder / user.name / f"{task.name}.npz"

    def key(self, user: User, task: Task) -> str:
        """Name all that a recording depends on; one with another key is simulated again."""
        until = f"{task.touches} touches" if task.touches else f"{task.seconds:g} s"
        return (
            f"version {VERSION}, {user.source(task)}, {'whole' if task.ends else until}, "
            f"hands {task.hands}, {self.tracker}"
        )

    def has(self, user: User, task: Task) -> bool:
        """Whether a recording is there and need not be simulated again."""
        if not self.simulates:
            return self.path(user, task).is_file()
        try:
            return read_key(self.path(user, task)) == self.key(user, task)
        except (OSError, ValueError):
            return False  # not there, or damaged

    def calibration(self, user: User) -> StoredRecording:
        """Return the user's calibration. Raises OSError where it is not there."""
        return load(self.path(user, CALIBRATION))

    def ensure(self, user: User, task: Task) -> None:
        """Simulate and store a recording that is not there. Raises OSError where it cannot."""
        if self.has(user, task):
            return
        assert self.simulates  # otherwise the plan holds cached recordings alone
        if task == CALIBRATION:
            recording = simulate_calibration(user, task, self.open_tracker)
        else:
            background = background_of(self.calibration(user))
            recording = simulate_task(user, task, background, self.open_tracker)
        save(self.path(user, task), recording, self.key(user, task))
