"""A profile as text and arrays: what stands in `profile.json`, and what in the files it names."""

from __future__ import annotations

import hashlib
import io
import math
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile.model import (
    PAPER_THRESHOLD_MM,
    Anchor,
    Background,
    Correction,
    HeldState,
    Profile,
    Projector,
    StepRecord,
    TouchStates,
)
from halo_service.values import Side

FORMAT = 1
"""Version of the folder's layout; a newer one is refused. Fields that are missing are defaults."""
ARRAYS = ("background", "correction")
"""Kinds of array files, and the keys under which the text names them."""
SURFACE = re.compile(r"(?!(?:control|sim)$)[a-z0-9_-]{1,32}")
"""What a surface may be called: its name is part of every address on the wire."""
STATES = ("hover", "subtle", "touch", "pressure")
GRID = ("x_mm", "y_mm", "pitch_deg", "yaw_deg", "strength", "samples")
DENTS = ("dent", "dent_by_pitch")
"""Arrays of a correction; older ones know nothing of dents."""
SAMPLE_COLUMNS = 6
"""Older samples have one less: no dents."""


def array_files(profile: Profile) -> dict[str, bytes]:
    """Return the array files by name, each named after its content."""
    background = profile.background
    kinds = {
        "background": {
            "mean_mm": background.mean_mm,
            "noise_mm": background.noise_mm,
            "valid": background.valid,
        }
    }
    if profile.correction is not None:
        correction = profile.correction
        kinds["correction"] = {
            name: getattr(correction, name)
            for name in (*GRID, *DENTS)
            if getattr(correction, name) is not None
        }
    files = {}
    for kind, arrays in kinds.items():
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        content = buffer.getvalue()
        files[f"{kind}-{hashlib.sha256(content).hexdigest()[:12]}.npz"] = content
    return files


def to_json(profile: Profile, files: list[str]) -> dict[str, Any]:
    """Return what `profile.json` says; `files`: names of the array files."""
    camera, surface = asdict(profile.camera), asdict(profile.surface)
    camera["colour_from_depth"] = profile.camera.colour_from_depth.tolist()
    surface["camera_from_surface"] = profile.surface.camera_from_surface.tolist()
    named = {name.partition("-")[0]: name for name in files}
    correction = profile.correction
    return {
        "format": FORMAT,
        "name": profile.name,
        "revision": profile.revision,
        "steps": {name: asdict(step) for name, step in profile.steps.items()},
        "camera": camera,
        "surface": surface,
        "background": named["background"],
        "halo_threshold_mm": profile.halo_threshold_mm,
        "touch": None if profile.touch is None else asdict(profile.touch),
        "touch_by_hand": {
            side.name.lower(): asdict(states) for side, states in profile.by_hand.items()
        },
        "correction": None
        if correction is None
        else {
            "arrays": named["correction"],
            "base": correction.base,
            "samples": len(correction.samples),
        },
        "projector": _as_text(profile.projector),
        "anchor": _as_text(profile.anchor),
    }


def from_json(data: dict[str, Any], folder: Path) -> Profile:
    """Read back what `to_json` wrote. Raises KeyError, TypeError, ValueError or OSError."""
    touch, correction = data["touch"], data.get("correction")
    profile = Profile(
        name=str(data["name"]),
        camera=_camera(data["camera"]),
        surface=_surface(data["surface"]),
        background=_background(folder / Path(data["background"]).name),
        touch=None if touch is None else _touch(touch),
        revision=int(data["revision"]),
        by_hand={
            Side[name.upper()]: _touch(states)
            for name, states in data.get("touch_by_hand", {}).items()
        },
        correction=None if correction is None else _correction(correction, folder),
        halo_threshold_mm=float(data.get("halo_threshold_mm", PAPER_THRESHOLD_MM)),
        projector=_projector(data.get("projector")),
        anchor=_anchor(data.get("anchor")),
        steps={name: StepRecord(**step) for name, step in data.get("steps", {}).items()},
    )
    wanted = (profile.camera.depth.height, profile.camera.depth.width)
    background = profile.background
    for array in (background.mean_mm, background.noise_mm, background.valid):
        if array.shape != wanted:
            raise ValueError("its background does not fit its camera")
    return profile


def _surface(data: dict[str, Any]) -> Surface:
    name, matrix = data["name"], _matrix(data, "camera_from_surface", 4)
    if not isinstance(name, str) or not SURFACE.fullmatch(name):
        raise ValueError(f"its surface cannot be called {name!r:.60}")
    width_mm, height_mm = float(data["width_mm"]), float(data["height_mm"])
    if not all(math.isfinite(size) and size > 0.0 for size in (width_mm, height_mm)):
        raise ValueError("its surface has no size")
    return Surface(name, width_mm, height_mm, matrix)


def _as_text(thing: Projector | Anchor | None) -> dict[str, Any] | None:
    if thing is None:
        return None
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in asdict(thing).items()
    }


def _projector(data: dict[str, Any] | None) -> Projector | None:
    if data is None:
        return None
    width_px, height_px = int(data["width_px"]), int(data["height_px"])
    if width_px <= 0 or height_px <= 0:
        raise ValueError("its projector's picture has no size")
    return Projector(width_px, height_px, _matrix(data, "projector_from_surface", 3))


def _anchor(data: dict[str, Any] | None) -> Anchor | None:
    if data is None:
        return None
    matrix = _matrix(data, "anchor_from_surface", 4)
    return Anchor(str(data["family"]), int(data["marker"]), float(data["size_mm"]), matrix)


def _matrix(data: dict[str, Any], name: str, size: int) -> NDArray[np.float64]:
    matrix = np.array(data[name], dtype=np.float64)
    if matrix.shape != (size, size) or not np.isfinite(matrix).all():
        raise ValueError(f"{name} is no {size} x {size} matrix")
    return matrix


def _camera(data: dict[str, Any]) -> Camera:
    colour = data["colour"]
    return Camera(
        **{
            **data,
            "depth": _lens(data["depth"]),
            "colour": None if colour is None else _lens(colour),
            "colour_from_depth": np.array(data["colour_from_depth"], dtype=np.float64),
        }
    )


def _lens(data: dict[str, Any]) -> Lens:
    return Lens(**{**data, "distortion": tuple(data["distortion"])})


def _touch(data: dict[str, Any]) -> TouchStates:
    return TouchStates(**{**data, **{name: _held(data[name]) for name in STATES}})


def _held(data: dict[str, Any]) -> HeldState:
    """Read a state; `dent_mm`, which the first profiles kept, was read another way."""
    return HeldState(**{name: value for name, value in data.items() if name != "dent_mm"})


def _background(path: Path) -> Background:
    read = _arrays(path, ("mean_mm", "noise_mm", "valid"))
    return Background(
        read["mean_mm"].astype(np.float32),
        read["noise_mm"].astype(np.float32),
        read["valid"].astype(np.bool_),
    )


def _correction(data: dict[str, Any], folder: Path) -> Correction:
    arrays = _arrays(folder / Path(data["arrays"]).name, GRID, DENTS)
    read = {name: array.astype(np.float32) for name, array in arrays.items()}
    shape = tuple(len(read[name]) for name in GRID[:4])
    shapes = {"strength": shape, "dent": shape[:2], "dent_by_pitch": shape[2:3]}
    if any(name in read and read[name].shape != wanted for name, wanted in shapes.items()):
        raise ValueError("its correction's grid does not fit its axes")
    missing = SAMPLE_COLUMNS - read["samples"].shape[1]
    read["samples"] = np.pad(read["samples"], ((0, 0), (0, missing)), constant_values=np.nan)
    return Correction(**read, base=str(data["base"]))


def _arrays(
    path: Path, names: tuple[str, ...], may: tuple[str, ...] = ()
) -> dict[str, NDArray[Any]]:
    """Read arrays by name, and those that may be there.

    Raises OSError where there is no file, ValueError for a damaged one.
    """
    content = path.read_bytes()
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            there = [name for name in may if name in arrays.files]
            return {name: arrays[name] for name in (*names, *there)}
    except Exception as error:
        # NumPy, zipfile and zlib have a dozen ways to say that bytes are not what was written.
        raise ValueError(f"its {path.name} is damaged") from error
