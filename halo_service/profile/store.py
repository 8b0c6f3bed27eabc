"""A profile on disk: a folder that a person can read and diff.

`profile.json` says everything in text and names the array file it belongs to; the array
file is written first and under a new name, then `profile.json` is replaced in one move.
So whoever reads it, at whatever moment, finds the old profile or the new one.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from platformdirs import user_data_path

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile.model import Background, HeldState, Profile, TouchStates

FORMAT = 1
"""Version of the folder's layout; a newer one is refused."""
TEXT = "profile.json"


def profile_path(name: str) -> Path:
    """Where a profile lives: a path if `name` has a separator, else in the user's data folder."""
    if "/" in name or os.sep in name:
        return Path(name).expanduser()
    return user_data_path("halo-service", appauthor=False) / "profiles" / name


def save(profile: Profile, folder: Path) -> None:
    """Write a profile; a kill at any moment leaves the old or the new one."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = _pack(profile.background)
    array_name = f"background-{hashlib.sha256(arrays).hexdigest()[:12]}.npz"
    _replace(folder / array_name, arrays)
    text = json.dumps(_to_json(profile, array_name), indent=2) + "\n"
    _replace(folder / TEXT, text.encode())
    for old in folder.glob("background-*.npz"):
        if old.name != array_name:
            old.unlink(missing_ok=True)


def load(folder: Path) -> Profile:
    """Read a profile. Raises `UserError` where there is none, or none that can be read."""
    text = folder / TEXT
    if not text.is_file():
        raise UserError(
            f"there is no profile at {folder}; give --profile the folder that holds its {TEXT}"
        )
    try:
        data = json.loads(text.read_text(encoding="utf-8"))
        if data["format"] > FORMAT:
            raise UserError(
                f"the profile {folder} was written by a newer halo-service (format "
                f"{data['format']}, this one reads {FORMAT}); update halo-service"
            )
        return _from_json(data, folder)
    except (KeyError, TypeError, ValueError, OSError, zipfile.BadZipFile) as error:
        raise UserError(
            f"the profile {folder} cannot be read ({error}); calibrate anew or restore it"
        ) from error


def require_fit(profile: Profile, camera: Camera) -> None:
    """Raise `UserError` when the profile belongs to another camera, mode or lens."""
    made = profile.camera
    for what, ours, theirs, same in (
        ("camera", camera.serial, made.serial, camera.serial == made.serial),
        ("depth mode", camera.depth_mode, made.depth_mode, camera.depth_mode == made.depth_mode),
        ("depth lens", camera.depth, made.depth, _same_lens(camera.depth, made.depth)),
    ):
        if not same:
            raise UserError(
                f"the profile '{profile.name}' belongs to {what} {theirs}, and this is {ours}; "
                f"choose the profile made with this camera, or calibrate it anew"
            )


def _same_lens(a: Lens, b: Lens) -> bool:
    """Compare to what a calibration file keeps of a lens; it is not read back to the last bit."""
    return np.allclose(_numbers(a), _numbers(b), rtol=1e-6, atol=1e-9)


def _numbers(lens: Lens) -> list[float]:
    return [lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy, *lens.distortion]


def _replace(path: Path, content: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    with temporary.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)


def _pack(background: Background) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer, mean_mm=background.mean_mm, noise_mm=background.noise_mm, valid=background.valid
    )
    return buffer.getvalue()


def _to_json(profile: Profile, array_name: str) -> dict[str, Any]:
    camera, surface = asdict(profile.camera), asdict(profile.surface)
    camera["colour_from_depth"] = profile.camera.colour_from_depth.tolist()
    surface["camera_from_surface"] = profile.surface.camera_from_surface.tolist()
    return {
        "format": FORMAT,
        "name": profile.name,
        "revision": profile.revision,
        "camera": camera,
        "surface": surface,
        "background": array_name,
        "touch": None if profile.touch is None else asdict(profile.touch),
    }


def _from_json(data: dict[str, Any], folder: Path) -> Profile:
    camera = dict(data["camera"])
    surface = dict(data["surface"])
    touch = data["touch"]
    return Profile(
        name=str(data["name"]),
        camera=Camera(
            **{
                **camera,
                "depth": _lens(camera["depth"]),
                "colour": None if camera["colour"] is None else _lens(camera["colour"]),
                "colour_from_depth": np.array(camera["colour_from_depth"], dtype=np.float64),
            }
        ),
        surface=Surface(
            **{
                **surface,
                "camera_from_surface": np.array(surface["camera_from_surface"], dtype=np.float64),
            }
        ),
        background=_unpack(folder / Path(data["background"]).name),
        touch=None if touch is None else _touch(touch),
        revision=int(data["revision"]),
    )


def _lens(data: dict[str, Any]) -> Lens:
    return Lens(**{**data, "distortion": tuple(data["distortion"])})


def _touch(data: dict[str, Any]) -> TouchStates:
    states = {name: HeldState(**data[name]) for name in ("hover", "subtle", "touch", "pressure")}
    return TouchStates(**{**data, **states})


def _unpack(path: Path) -> Background:
    with np.load(path, allow_pickle=False) as arrays:
        mean, noise, valid = arrays["mean_mm"], arrays["noise_mm"], arrays["valid"]
    return Background(mean.astype(np.float32), noise.astype(np.float32), valid.astype(np.bool_))
