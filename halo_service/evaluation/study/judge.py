"""Compares what a method published with the truth: the one place where the two meet."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from halo_service.errors import UserError
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.metrics.scores import score
from halo_service.evaluation.metrics.scripted import score_script
from halo_service.evaluation.metrics.truth import Line, read_truth
from halo_service.evaluation.report.select import RECORDING
from halo_service.evaluation.study.calibrate import profile_hash, settings_hash
from halo_service.evaluation.study.sense import SharedTracker, captures_of, sense_all
from halo_service.evaluation.study.simulate import Tracker
from halo_service.files import read_text
from halo_service.profile import Profile
from halo_service.runtime.method import Method
from halo_service.sensing import SensingSettings
from halo_service.sources import Source
from halo_service.values import TouchFrame


def judge(
    subject: Subject,
    task: str,
    method: str,
    published: Sequence[TouchFrame],
    truth: Sequence[Line] | None,
    script: Sequence[Line],
    profile: Profile,
    settings: SensingSettings,
) -> Result:
    """Score what a method published for one recording; `truth` None: by the script."""
    if truth is None:
        scores = score_script(published, script, profile.surface)
    else:
        scores = score(published, truth, script, profile.surface)
    hashes = profile_hash(profile), settings_hash(settings)
    return Result(subject, task, method, scores, "", *hashes, by_script=truth is None)


def judge_recording(
    source: Source,
    name: str,
    track: Tracker,
    methods: Sequence[Method[Any]],
    profile: Profile,
    settings: SensingSettings,
    truth: Sequence[Line] | None,
    script: Sequence[Line],
) -> tuple[Result, ...]:
    """Run methods over a recording with the same profile, and score them.

    Raises `UserError` where the recording breaks off, or truth or script cannot be understood.
    """
    _require_sense(truth, script, profile)
    profiles = dict.fromkeys((method.name for method in methods), profile)
    published = sense_all(
        captures_of(source), source.camera, SharedTracker(track), methods, profiles, settings
    )
    results = []
    for method in methods:
        result = judge(
            Subject(name), RECORDING, method.name, published[method.name],
            truth, script, profile, settings,
        )  # fmt: skip
        remark = "" if method.learn is None else _not_calibrated(method.name)
        results.append(replace(result, remark=remark))
    return tuple(results)


def read_lines(path: Path, what: str) -> tuple[Line, ...]:
    """Read one JSON object per line, or a list of them. Raises `UserError` for anything else."""
    try:
        text = read_text(path)
        whole = text.lstrip().startswith("[")
        lines = json.loads(text) if whole else [json.loads(each) for each in text.splitlines()]
        if not all(isinstance(each, dict) for each in lines):
            raise ValueError("a line is no object")
    except (OSError, ValueError) as error:
        raise UserError(
            f"the {what} {path} cannot be read ({error}); name the right file"
        ) from error
    return tuple(lines)


def _not_calibrated(method: str) -> str:
    return (
        f"'{method}' was not calibrated with its own signal here, so its levels, heights and "
        f"pressures are off."
    )


def _require_sense(truth: Sequence[Line] | None, script: Sequence[Line], profile: Profile) -> None:
    """Raise `UserError` for a wrong truth or script, before a recording is sensed."""
    try:
        if truth is not None and not read_truth(truth, profile.surface).frames:
            raise ValueError("it has no frame")
        for step in script:
            if not step["from_s"] < step["to_s"]:
                raise ValueError(f"the step {step['step']!r} ends before it begins")
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise UserError(
            f"the truth or script cannot be understood ({error!r}); give the files that "
            f"'halo simulate' wrote with the recording"
        ) from error
