"""What was asked for, where nobody knows the truth: a person under a real camera.

Somebody follows a script: touch this cross once, rest the finger on this spacer, press until the
scale shows that. What was told is judged against what was asked, as the paper's study did (5.2).
So people's own errors are in every figure, and what only the truth tells (when exactly, how fast,
whose finger) is left open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from halo_service.evaluation.metrics.behaviour import Conduct
from halo_service.evaluation.metrics.confidence import Sureness
from halo_service.evaluation.metrics.levels import LEVELS
from halo_service.evaluation.metrics.scores import Scores, score
from halo_service.evaluation.metrics.truth import Line
from halo_service.geometry.surface import Surface
from halo_service.values import TouchFrame

TARGET = "target"
"""Step of the script: one touch of `target_mm`, surface frame, while it lasts."""
WHO = {"hand": "unknown", "finger": "index"}
"""Nobody knows whose finger it was."""


def score_asked(frames: Sequence[TouchFrame], script: Sequence[Line], surface: Surface) -> Scores:
    """Judge published frames against a script alone; its times count from the first frame.

    Steps: `target` with its `target_mm`, `hover` with its `height_mm`, `pressure` with its
    `force_g`. Touches told while no target was asked for are not judged.
    """
    if not frames:
        return score((), (), (), surface)
    start_us = frames[0].time_us
    targets = [step for step in script if step.get("step") == TARGET]
    within = [
        frame if _during(targets, frame, start_us) else replace(frame, events=())
        for frame in frames
    ]
    lines = [_contact(step, start_us, surface) for step in targets]
    lines += [_frame(frame, script, start_us, surface) for frame in frames]
    scores = score(within, lines, script, surface)
    return replace(
        scores,
        sureness=Sureness(),
        timing=(),
        strikes=(),
        velocities=(),
        conduct=Conduct(),
        jumps=(),
        phrases=(),
    )


def _during(steps: Sequence[Line], frame: TouchFrame, start_us: int) -> Line | None:
    """Return the step that a frame belongs to."""
    seconds = (frame.time_us - start_us) / 1e6
    return next((step for step in steps if step["from_s"] <= seconds <= step["to_s"]), None)


def _contact(step: Line, start_us: int, surface: Surface) -> Line:
    """Return the truth's line of a touch that lasts as long as it is asked for."""
    x, y = step["target_mm"]
    return {
        "contact": WHO
        | {
            "from_us": start_us + round(1e6 * step["from_s"]),
            "to_us": start_us + round(1e6 * step["to_s"]),
            "camera_mm": surface.to_camera(np.array([[x, y, 0.0]]))[0].tolist(),
            "strike_mm_s": 0.0,
            "target_mm": [x, y],
        }
    }


def _frame(frame: TouchFrame, script: Sequence[Line], start_us: int, surface: Surface) -> Line:
    """Return the truth's line of a frame: a finger at the level asked for, where one is told."""
    step = _during([each for each in script if each.get("step") in LEVELS], frame, start_us)
    if step is None:
        return {"time_us": frame.time_us, "fingers": []}
    lowest = min(frame.pointers, key=lambda pointer: pointer.hover_mm, default=None)
    x, y = (lowest.x_mm, lowest.y_mm) if lowest else (0.0, 0.0)
    height_mm = float(step.get("height_mm", 0.0))
    finger = WHO | {
        "camera_mm": surface.to_camera(np.array([[x, y, -height_mm]]))[0].tolist(),
        "height_mm": height_mm,
        "touching": False,
        "force_g": float(step.get("force_g", 0.0)),
    }
    return {"time_us": frame.time_us, "fingers": [finger]}
