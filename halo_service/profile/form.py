"""A profile as text and arrays: what stands in `profile.json`, and what in the files it names."""

from __future__ import annotations

import hashlib
import io
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile.model import (
    PAPER_THRESHOLD_MM,
    Background,
    Correction,
    HeldState,
    Profile,
    StepRecord,
    TouchStates,
)
from halo_service.values import Side

FORMAT = 1
"""Version of the folder's layout; a newer one is refused. Fields that are missing are defaults."""
ARRAYS = ("background", "correction")
"""Kinds of array files, and the keys under which the text names them."""
STATES = ("hover", "subtle", "touch", "pressure")


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
            for name in ("x_mm", "y_mm", "pitch_deg", "yaw_deg", "strength", "samples")
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
    }


def from_json(data: dict[str, Any], folder: Path) -> Profile:
    """Read back what `to_json` wrote. Raises KeyError, TypeError, ValueError or OSError."""
    surface, touch, correction = dict(data["surface"]), data["touch"], data.get("correction")
    matrix = np.array(surface.pop("camera_from_surface"), dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError("camera_from_surface is no 4 x 4 matrix")
    profile = Profile(
        name=str(data["name"]),
        camera=_camera(data["camera"]),
        surface=Surface(**surface, camera_from_surface=matrix),
        background=_background(folder / Path(data["background"]).name),
        touch=None if touch is None else _touch(touch),
        revision=int(data["revision"]),
        by_hand={
            Side[name.upper()]: _touch(states)
            for name, states in data.get("touch_by_hand", {}).items()
        },
        correction=None if correction is None else _correction(correction, folder),
        halo_threshold_mm=float(data.get("halo_threshold_mm", PAPER_THRESHOLD_MM)),
        steps={name: StepRecord(**step) for name, step in data.get("steps", {}).items()},
    )
    wanted = (profile.camera.depth.height, profile.camera.depth.width)
    if profile.background.mean_mm.shape != wanted:
        raise ValueError("its background does not fit its camera")
    return profile


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
    return TouchStates(**{**data, **{name: HeldState(**data[name]) for name in STATES}})


def _background(path: Path) -> Background:
    with np.load(path, allow_pickle=False) as arrays:
        mean, noise, valid = arrays["mean_mm"], arrays["noise_mm"], arrays["valid"]
    return Background(mean.astype(np.float32), noise.astype(np.float32), valid.astype(np.bool_))


def _correction(data: dict[str, Any], folder: Path) -> Correction:
    names = ("x_mm", "y_mm", "pitch_deg", "yaw_deg", "strength", "samples")
    with np.load(folder / Path(data["arrays"]).name, allow_pickle=False) as arrays:
        read = {name: arrays[name].astype(np.float32) for name in names}
    if read["strength"].shape != tuple(len(read[name]) for name in names[:4]):
        raise ValueError("its correction's grid does not fit its axes")
    return Correction(**read, base=str(data["base"]))
