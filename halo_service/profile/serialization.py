"""A profile as text and arrays: the content of `profile.json` and of the array files it names."""

from __future__ import annotations

import hashlib
import io
import math
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, ConfigDict, TypeAdapter, ValidationError

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface, line_of_sight_deg
from halo_service.profile.model import (
    PAPER_THRESHOLD_MM,
    Anchor,
    Background,
    Correction,
    Profile,
    Projector,
    StepRecord,
    TouchState,
    TouchStates,
)
from halo_service.validation import sentences
from halo_service.values import Side

FORMAT = 1
"""Version of the folder's layout; a newer one is refused. Fields that are missing are defaults."""
ARRAYS = ("background", "correction")
"""Kinds of array files, and the keys under which the text names them."""
SURFACE = re.compile(r"(?!(?:control|sim)$)[a-z0-9_-]{1,32}")
"""What a surface may be called: its name is part of every address on the wire."""
READINGS = 4
GRID = ("x_mm", "y_mm", "pitch_deg", "yaw_deg", "strength", "samples")
DENTS = ("readings", "deviations", "dent_by_pitch", "tops_mm")
"""Arrays of a correction; older ones know only the signal."""
SAMPLE_COLUMNS, OLD_COLUMNS = 9, (8, 5)
"""Older samples have fewer; so many of those are the same."""


def _checked_surface(surface: Surface) -> Surface:
    """Return a surface. Raises ValueError for a name or a size that it cannot have."""
    if not SURFACE.fullmatch(surface.name):
        raise ValueError(f"'name' cannot be {surface.name!r:.60}")
    if not all(math.isfinite(mm) and mm > 0.0 for mm in (surface.width_mm, surface.height_mm)):
        raise ValueError("'width_mm' and 'height_mm' must be more than 0")
    return surface


def _hand(side: Side) -> Any:
    """Return a hand's name in the text: `unknown`, `left` or `right`."""
    return side.name.lower()


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
    if background.infrared is not None:
        kinds["background"]["infrared"] = background.infrared
        kinds["background"]["infrared_noise"] = np.array(background.infrared_noise)
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


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectionText:
    """What `profile.json` says of the correction."""

    arrays: str
    """Name of its array file."""
    base: str
    samples: int = 0
    """How many samples it holds, for readers of the text."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProfileText:
    """All of `profile.json`, in its order. A field with a default may be missing in older ones."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="ignore")

    format: int = FORMAT
    name: str
    revision: int
    steps: dict[str, StepRecord] = field(default_factory=dict)
    camera: Camera
    surface: Annotated[Surface, AfterValidator(_checked_surface)]
    background: str
    """Name of its array file."""
    halo_threshold_mm: float = PAPER_THRESHOLD_MM
    touch: TouchStates | None
    touch_by_hand: dict[Literal["unknown", "left", "right"], TouchStates] = field(
        default_factory=dict
    )
    correction: CorrectionText | None = None
    projector: Projector | None = None
    anchor: Anchor | None = None


ADAPTER = TypeAdapter(ProfileText)


def to_json(profile: Profile, files: list[str]) -> dict[str, Any]:
    """Return what `profile.json` says; `files`: names of the array files."""
    named = {name.partition("-")[0]: name for name in files}
    correction = profile.correction
    text = ProfileText(
        name=profile.name,
        revision=profile.revision,
        steps=dict(profile.steps),
        camera=profile.camera,
        surface=profile.surface,
        background=named["background"],
        halo_threshold_mm=profile.halo_threshold_mm,
        touch=profile.touch,
        touch_by_hand={_hand(side): states for side, states in profile.by_hand.items()},
        correction=None
        if correction is None
        else CorrectionText(
            arrays=named["correction"], base=correction.base, samples=len(correction.samples)
        ),
        projector=profile.projector,
        anchor=profile.anchor,
    )
    written: dict[str, Any] = ADAPTER.dump_python(text)
    return written


def from_json(data: dict[str, Any], folder: Path) -> Profile:
    """Read back what `to_json` wrote. Raises ValueError with a sentence, or OSError."""
    try:
        text = ADAPTER.validate_python(data)
    except ValidationError as error:
        raise ValueError(sentences(error, ProfileText)[0]) from error
    profile = Profile(
        name=text.name,
        camera=text.camera,
        surface=text.surface,
        background=_background(folder / Path(text.background).name),
        touch=None if text.touch is None else _seen(text.touch, text.surface),
        revision=text.revision,
        by_hand={
            Side[name.upper()]: _seen(states, text.surface)
            for name, states in text.touch_by_hand.items()
        },
        correction=None if text.correction is None else _correction(text.correction, folder),
        halo_threshold_mm=text.halo_threshold_mm,
        projector=text.projector,
        anchor=text.anchor,
        steps=text.steps,
    )
    wanted = (profile.camera.depth.height, profile.camera.depth.width)
    background = profile.background
    arrays = (background.mean_mm, background.noise_mm, background.valid, background.infrared)
    for array in arrays:
        if array is not None and array.shape != wanted:
            raise ValueError("its background does not fit its camera")
    return profile


def _seen(states: TouchStates, surface: Surface) -> TouchStates:
    """Return states with the angle at which the camera saw each, which older ones do not have."""

    def seen(state: TouchState) -> TouchState:
        if state.seen_deg is not None or state.top_mm is None:
            return state
        place = surface.to_camera(np.array([[state.x_mm, state.y_mm, 0.0]]))[0]
        angle = line_of_sight_deg(tuple(place.tolist()), state.pitch_deg, state.yaw_deg, surface)
        return replace(state, seen_deg=angle)

    return states.with_each(seen)


def _background(path: Path) -> Background:
    read = _arrays(path, ("mean_mm", "noise_mm", "valid"), ("infrared", "infrared_noise"))
    infrared = read.get("infrared")
    return Background(
        read["mean_mm"].astype(np.float32),
        read["noise_mm"].astype(np.float32),
        read["valid"].astype(np.bool_),
        None if infrared is None else infrared.astype(np.float32),
        float(read.get("infrared_noise", 0.0)),
    )


def _correction(text: CorrectionText, folder: Path) -> Correction:
    arrays = _arrays(folder / Path(text.arrays).name, GRID, DENTS)
    read = {name: array.astype(np.float32) for name, array in arrays.items()}
    shape = tuple(len(read[name]) for name in GRID[:4])
    shapes = {"strength": shape, "dent_by_pitch": shape[2:3]}
    shapes |= dict.fromkeys(("readings", "deviations"), (READINGS, *shape[:2]))
    shapes |= {"tops_mm": (2, *shape[:2])}
    if any(name in read and read[name].shape != wanted for name, wanted in shapes.items()):
        raise ValueError("its correction's grid does not fit its axes")
    stored = read["samples"].shape[1]
    if stored < SAMPLE_COLUMNS:
        same = next((count for count in OLD_COLUMNS if count <= stored), 0)
        if not same:
            raise ValueError("its correction's samples have too few columns")
        missing = (0, 0), (0, SAMPLE_COLUMNS - same)
        read["samples"] = np.pad(read["samples"][:, :same], missing, constant_values=np.nan)
    return Correction(**read, base=text.base)


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
