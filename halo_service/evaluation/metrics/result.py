"""The result of one method for one task of one user."""

from __future__ import annotations

from dataclasses import dataclass

from halo_service.evaluation.metrics.scores import Scores


@dataclass(frozen=True, slots=True)
class Subject:
    """Who was recorded. Of a recording only the name is known."""

    name: str
    seed: int | None = None
    material: str = ""
    family: str = ""
    """Of halo curves."""
    halo: str = ""
    """Shape of the footprint, `bell` or `odd`."""
    skin_offset_mm: float | None = None
    """How much too far the user's skin reads."""
    curl: float | None = None
    """Of the other fingers: 0 hanging, 1 a fist."""
    height_mm: float | None = None
    """Of the camera."""
    mode: str = ""
    """Of the depth camera."""
    device: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """A method's scores, and what they depend on."""

    subject: Subject
    task: str
    """Its name in the plan; `recording` for a recording."""
    method: str
    scores: Scores | None
    """None where the method could not be calibrated for the subject."""
    refused: str = ""
    """Why it could not, in one sentence; else empty."""
    profile: str = ""
    """Hash of the profile."""
    settings: str = ""
    """Hash of the sensing's configuration."""
    by_script: bool = False
    """Compared with what a script asked for, because the truth is unknown."""
    remark: str = ""
    """A sentence without which the method's figures would mislead."""
