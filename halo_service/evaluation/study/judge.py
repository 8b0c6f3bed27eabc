"""What a method published, judged: the one place where frames meet the truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from halo_service.errors import UserError
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.metrics.scores import score
from halo_service.evaluation.metrics.scripted import score_asked
from halo_service.evaluation.metrics.truth import read_truth
from halo_service.evaluation.report.select import RECORDING
from halo_service.evaluation.study.calibrate import profile_hash, settings_hash
from halo_service.evaluation.study.recording import Line
from halo_service.evaluation.study.sense import Look, Once, captures_of, together
from halo_service.profile import Profile
from halo_service.runtime.method import Method
from halo_service.sensing import SensingSettings
from halo_service.sources import Source
from halo_service.values import TouchFrame


def judged(
    subject: Subject,
    task: str,
    method: str,
    told: Sequence[TouchFrame],
    truth: Sequence[Line] | None,
    script: Sequence[Line],
    profile: Profile,
    settings: SensingSettings,
) -> Result:
    """Score what a method published of one take; `truth` None: by what the script asked for."""
    if truth is None:
        scores = score_asked(told, script, profile.surface)
    else:
        scores = score(told, truth, script, profile.surface)
    hashes = profile_hash(profile), settings_hash(settings)
    return Result(subject, task, method, scores, "", *hashes, asked=truth is None)


def recording_judged(
    source: Source,
    name: str,
    look: Look,
    methods: Sequence[Method[Any]],
    profile: Profile,
    settings: SensingSettings,
    truth: Sequence[Line] | None,
    script: Sequence[Line],
) -> tuple[Result, ...]:
    """Run methods over a recording with one and the same profile, and judge them.

    Raises `UserError` where the recording breaks off, or truth or script is none.
    """
    _require_sense(truth, script, profile)
    profiles = dict.fromkeys((method.name for method in methods), profile)
    told = together(captures_of(source), source.camera, Once(look), methods, profiles, settings)
    subject = Subject(name)
    results = []
    for method in methods:
        name = method.name
        result = judged(subject, RECORDING, name, told[name], truth, script, profile, settings)
        results.append(result if method.learn is None else replace(result, remark=_not_its(name)))
    return tuple(results)


def _not_its(method: str) -> str:
    return (
        f"'{method}' was not calibrated with its own signal here, so its levels, heights and "
        f"pressures are off."
    )


def _require_sense(truth: Sequence[Line] | None, script: Sequence[Line], profile: Profile) -> None:
    """Raise `UserError` for a truth or a script that is none, before a recording is sensed."""
    try:
        if truth is not None and not read_truth(truth, profile.surface).frames:
            raise ValueError("it tells of no frame")
        for step in script:
            if not step["from_s"] < step["to_s"]:
                raise ValueError(f"the step {step['step']!r} ends before it begins")
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise UserError(
            f"the truth or script cannot be understood ({error!r}); give the files that "
            f"'halo simulate' wrote beside the recording"
        ) from error


def read_lines(path: Path, what: str) -> tuple[Line, ...]:
    """Read one JSON object a line, or a list of them. Raises `UserError` for what is neither."""
    try:
        text = path.read_text(encoding="utf-8")
        whole = text.lstrip().startswith("[")
        lines = json.loads(text) if whole else [json.loads(each) for each in text.splitlines()]
        if not all(isinstance(each, dict) for each in lines):
            raise ValueError("a line is no object")
    except (OSError, ValueError) as error:
        raise UserError(
            f"the {what} {path} cannot be read ({error}); name the right file"
        ) from error
    return tuple(lines)
