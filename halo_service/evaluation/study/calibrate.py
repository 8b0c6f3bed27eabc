"""Calibrates a virtual user like any other: by the steps of `halo calibrate --script`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from halo_calibration.scripted.run import ScriptedCalibration
from halo_calibration.scripted.script import parse_script
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.errors import UserError
from halo_service.evaluation.study.recording import StoredRecording, restored
from halo_service.evaluation.study.sense import CachedHands, FrameSequence
from halo_service.evaluation.study.simulate import background_of, profile_of_table
from halo_service.geometry.camera import Camera
from halo_service.profile import Background, Profile
from halo_service.profile.serialization import array_files, to_json
from halo_service.runtime.method import OURS, Method
from halo_service.sensing import SensingSettings

NAME = "bench"
DATE = "1970-01-01T00:00:00Z"
"""Of profiles. A stored recording has no date: the same recording gives the same profile."""


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedUser:
    """One user with a profile for each method."""

    background: Background | None
    """Over which stored frames are restored; None where the empty table was refused."""
    profiles: Mapping[str, Profile]
    """By the method's name."""
    refused: Mapping[str, str]
    """The methods that could not be calibrated, each with the reason in one sentence."""


def calibrate(
    recording: StoredRecording,
    camera: Camera,
    methods: Sequence[Method[Any]],
    settings: SensingSettings,
) -> CalibratedUser:
    """Calibrate each method on a user's calibration recording, made with `camera`.

    Where our calibration refuses, the rivals get the empty table: none of them reads our states.
    """
    background = background_of(recording)
    try:
        profile, reason = by_script(recording, camera, background, settings), ""
    except UserError as error:
        profile, reason = profile_of_table(NAME, background, camera), str(error)
    profiles, refused = {}, {}
    for method in methods:
        if reason and method is OURS:
            refused[method.name] = reason
            continue
        try:
            profiles[method.name] = _learnt(method, profile, settings, recording, background)
        except UserError as error:
            refused[method.name] = str(error)
    return CalibratedUser(background, profiles, refused)


def by_script(
    recording: StoredRecording, camera: Camera, background: Background, settings: SensingSettings
) -> Profile:
    """Return the profile that `halo calibrate --script` makes of a recording, or `UserError`."""
    track = CachedHands(recording)
    source = FrameSequence((frame for frame, _ in restored(recording, background)), camera)
    setup = Setup(NAME, camera, DATE, settings)
    scripted = ScriptedCalibration(setup, Session(source), lambda _: track, lambda _: None)
    return scripted.run(parse_script(list(recording.script), "of the recording"))


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
    recording: StoredRecording,
    background: Background,
) -> Profile:
    if method.learn is None:
        return profile
    seen = restored(recording, background, method.whole_image)
    return method.learn(profile, settings, seen, recording.script)
