"""What the steps have found so far, for the page. Pure."""

from __future__ import annotations

from typing import Any

from halo_calibration.steps.background import BY_BACKGROUND
from halo_service.app.calibration_ui.verdict import step_sentence
from halo_service.profile import Profile, StepRecord


def found(profile: Profile | None, camera: StepRecord | None) -> dict[str, Any]:
    """Return the result of each step, by its name.

    `camera`: how the camera is placed, where no profile stores it yet.
    """
    records = dict(profile.steps) if profile else {}
    if camera is not None:
        records.setdefault("camera", camera)
    newest = profile.changed if profile else ""
    return {
        name: {
            "quality": record.quality,
            "text": step_sentence(name, record),
            "date": record.date,
            "by_background": record.note.startswith(BY_BACKGROUND),
            "outdated": name == "verify" and record.date < newest,
        }
        for name, record in records.items()
    }
