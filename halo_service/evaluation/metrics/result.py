"""What one method made of one task of one person."""

from __future__ import annotations

from dataclasses import dataclass

from halo_service.evaluation.metrics.scores import Scores


@dataclass(frozen=True, slots=True)
class Subject:
    """Whose take it was. A recording's subject has a name and nothing else that is known."""

    name: str
    seed: int | None = None
    material: str = ""
    family: str = ""
    """Of halo curves."""


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """A method's scores, and what they depend on."""

    subject: Subject
    task: str
    """By its name in the matrix; a recording's is `recording`."""
    method: str
    scores: Scores | None
    """None where the subject could not be calibrated for this method."""
    refused: str = ""
    """The sentence that says why, else empty."""
    profile: str = ""
    """Hash of the profile."""
    settings: str = ""
    """Hash of the sensing's configuration."""
    asked: bool = False
    """Judged by what a script asked for: nobody knew the truth."""
    remark: str = ""
    """A sentence without which the method's figures would mislead."""
