"""Calibrates a person as any user is: by the steps of `halo calibrate --script`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from halo_calibration.base_model import VIRTUAL, read_base
from halo_calibration.scripted.run import Scripted
from halo_calibration.scripted.script import parse_script
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.errors import UserError
from halo_service.evaluation.study.cache import background_of, profile_of_table
from halo_service.evaluation.study.plan import CALIBRATION
from halo_service.evaluation.study.recording import Kept, load, played
from halo_service.evaluation.study.sense import Played, Remembered
from halo_service.profile import Background, Profile
from halo_service.profile.serialization import array_files, to_json
from halo_service.runtime.method import OURS, Method
from halo_service.sensing import SensingSettings
from halo_service.virtual.camera import factory

NAME = "bench"
DATE = "1970-01-01T00:00:00Z"
"""Of profiles. A kept take has no date, and the same take gives the same profile."""


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """One person, as each method knows them."""

    background: Background | None
    """Over which kept frames are given back; None where the empty table was refused."""
    profiles: Mapping[str, Profile]
    """By the method's name."""
    refused: Mapping[str, str]
    """The methods that could not be calibrated, and the sentence that says why."""


def calibrate(
    folder: Path, methods: Sequence[Method[Any]], settings: SensingSettings
) -> Calibrated:
    """Calibrate the person whose takes are in a folder, for each method.

    Where our calibration refuses, the rivals have the empty table: none of them reads our states.
    """
    kept = load(folder / f"{CALIBRATION.name}.npz")
    background = background_of(folder)
    try:
        profile, why = by_script(kept, background, settings), ""
    except UserError as error:
        profile, why = profile_of_table(NAME, background), str(error)
    profiles, refused = {}, {}
    for method in methods:
        if why and method is OURS:
            refused[method.name] = why
            continue
        try:
            profiles[method.name] = _learnt(method, profile, settings, kept, background)
        except UserError as error:
            refused[method.name] = str(error)
    return Calibrated(background, profiles, refused)


def by_script(kept: Kept, background: Background, settings: SensingSettings) -> Profile:
    """Return the profile that `halo calibrate --script` makes of such a take, or `UserError`."""
    look = Remembered(kept)
    source = Played(frame for frame, _ in played(kept, background))
    setup = Setup(NAME, factory(), DATE, settings, base=read_base(VIRTUAL))
    scripted = Scripted(setup, Session(source), lambda _: look, lambda _: None)
    return scripted.run(parse_script(list(kept.script), "of the take"))


def profile_hash(profile: Profile) -> str:
    """Name a profile by its content."""
    text = json.dumps(to_json(profile, list(array_files(profile))), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def settings_hash(settings: SensingSettings) -> str:
    """Name a configuration of the sensing by its content."""
    text = json.dumps(asdict(settings), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _learnt(
    method: Method[Any],
    profile: Profile,
    settings: SensingSettings,
    kept: Kept,
    background: Background,
) -> Profile:
    if method.learn is None:
        return profile
    return method.learn(profile, settings, played(kept, background), kept.script)
