"""A profile on disk: a folder that a person can read and diff.

`profile.json` says everything in text and names the array files it belongs to; these are written
first and under new names, then `profile.json` is replaced in one move. So whoever reads it, at
whatever moment, finds the old profile or the new one. Writers take turns by a lock, which the
system takes back from one that was killed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from filelock import Timeout

from halo_service.errors import UserError
from halo_service.files import data_folder, folder_lock, from_home
from halo_service.geometry.camera import Camera, Lens
from halo_service.profile.model import Profile
from halo_service.profile.serialization import ARRAYS, FORMAT, array_files, from_json, to_json

TEXT = "profile.json"
TRIES = 5
"""A reader retries when a writer removes old files; each time the text has to be newer."""

UNREADABLE = (
    LookupError,
    TypeError,
    ValueError,
    AttributeError,
    ArithmeticError,
    RuntimeError,
    OSError,
)
"""What reading a damaged or foreign text can raise: values, shapes, nesting."""


def profiles_path() -> Path:
    """Return the folder of the user's profiles."""
    return data_folder() / "profiles"


def profile_path(name: str) -> Path:
    """Where a profile lives: a path if `name` has a separator, else in the user's data folder."""
    if "/" in name or os.sep in name:
        return from_home(name)
    return profiles_path() / name


def option_for(folder: Path) -> str:
    """Return what `--profile` is for a folder: its name in the data folder, else its path."""
    try:
        return folder.name if folder.parent == profiles_path() else str(folder)
    except UserError:  # this user has no data folder
        return str(folder)


def exists(folder: Path) -> bool:
    """Say whether there is a profile in a folder, readable or not."""
    return (folder / TEXT).is_file()


def save(profile: Profile, folder: Path) -> None:
    """Write a profile; a kill at any moment leaves the old or the new one.

    Raises `UserError` where the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with folder_lock(folder):
            _write(profile, folder)
    except OSError as error:
        raise _unwritable(folder, error) from error


def amend(folder: Path, change: Callable[[Profile | None], Profile]) -> Profile:
    """Change a profile under its lock; its revision grows. Returns what was saved.

    `change`: the profile as it is (None: there is none yet) to what it shall be.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with folder_lock(folder):
            before = load(folder) if exists(folder) else None
            revision = before.revision + 1 if before else 1
            after = replace(change(before), revision=revision)
            _write(after, folder)
    except OSError as error:
        raise _unwritable(folder, error) from error
    return after


def load(folder: Path) -> Profile:
    """Read a profile. Raises `UserError` where there is none, or none that can be read."""
    path = folder / TEXT
    if not path.is_file():
        raise UserError(
            f"there is no profile at {folder}; make one with 'halo calibrate --profile "
            f"{option_for(folder)}', or give --profile the folder that holds its {TEXT}"
        )
    try:
        text = path.read_bytes()
        for _ in range(TRIES):
            try:
                return _read(text, folder)
            except FileNotFoundError:
                newer = path.read_bytes()
                if newer == text:
                    raise
                text = newer
        raise OSError("it changes all the time")
    except UNREADABLE as error:
        raise UserError(
            f"the profile {folder} cannot be read ({error}); restore it, or remove it and "
            f"calibrate again"
        ) from error


def require_fit(profile: Profile, camera: Camera) -> None:
    """Raise `UserError` when the profile belongs to another camera, mode or lens."""
    differs = difference(camera, profile.camera)
    if differs is not None:
        what, ours, theirs = differs
        raise UserError(
            f"the profile '{profile.name}' belongs to {what} {theirs}, and this is {ours}; "
            f"choose the profile made with this camera, or calibrate again"
        )


def difference(ours: Camera, theirs: Camera) -> tuple[str, object, object] | None:
    """Return in what two cameras differ, and what each has; None: their frames are alike."""
    if ours.serial != theirs.serial:
        return "camera", ours.serial, theirs.serial
    if ours.depth_mode != theirs.depth_mode:
        return "depth mode", ours.depth_mode, theirs.depth_mode
    if not _same_lens(ours.depth, theirs.depth):
        return "depth lens", ours.depth, theirs.depth
    return None


def require_touch(profile: Profile) -> None:
    """Raise `UserError` for a profile without touch states."""
    if profile.touch is None:
        raise UserError(
            f"the profile {profile.name} has no touch states, so touches cannot be detected: "
            "run 'halo calibrate touch' with it"
        )


def _same_lens(a: Lens, b: Lens) -> bool:
    """Compare to the precision of a calibration file; it does not store the last bit."""
    return np.allclose(_numbers(a), _numbers(b), rtol=1e-6, atol=1e-9)


def _numbers(lens: Lens) -> list[float]:
    return [lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy, *lens.distortion]


def _read(text: bytes, folder: Path) -> Profile:
    data: dict[str, Any] = json.loads(text)
    if data["format"] > FORMAT:
        raise UserError(
            f"the profile {folder} was written by a newer halo-service (format "
            f"{data['format']}, this one reads {FORMAT}); update halo-service"
        )
    return from_json(data, folder)


def _write(profile: Profile, folder: Path) -> None:
    files = array_files(profile)
    for name, content in files.items():
        if not _holds(folder / name, content):
            _replace(folder / name, content)
    text = json.dumps(to_json(profile, list(files)), indent=2) + "\n"
    _replace(folder / TEXT, text.encode())
    for kind in ARRAYS:
        for old in folder.glob(f"{kind}-*.npz"):
            if old.name not in files:
                old.unlink(missing_ok=True)
    for left in folder.glob(".*.part"):  # by a writer that was killed: we hold the lock
        left.unlink(missing_ok=True)


def _holds(path: Path, content: bytes) -> bool:
    """A file's name is its content's hash; a damaged file is written again."""
    return path.is_file() and path.read_bytes() == content


def _replace(path: Path, content: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    with temporary.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)


def _unwritable(folder: Path, error: OSError) -> UserError:
    busy = isinstance(error, Timeout)
    reason = "another program is writing it" if busy else error.strerror or error
    return UserError(
        f"the profile {folder} cannot be written ({reason}); choose another "
        f"place with --profile, or free some space"
    )
