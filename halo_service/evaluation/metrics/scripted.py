"""Scores by a script where the truth is unknown: a person under a real camera.

The person follows a script: touch this cross once, rest the finger on this spacer, press until the
scale shows this. What is reported is compared with what the script asked for, as in the paper's
study (5.2). So people's own errors are in every figure, and figures that need the truth (exact
time, speed, which finger) stay empty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from halo_service.evaluation.metrics.behaviour import Behaviour
from halo_service.evaluation.metrics.confidence import Confidence
from halo_service.evaluation.metrics.levels import LEVELS
from halo_service.evaluation.metrics.scores import Scores, score
from halo_service.evaluation.metrics.truth import Line
from halo_service.geometry.surface import Surface
from halo_service.values import TouchFrame

TARGET = "target"
"""Step of the script: one touch of `target_mm`, surface frame, during the step."""
UNKNOWN_FINGER = {"hand": "unknown", "finger": "index"}
"""A script does not know the hand."""


def score_script(frames: Sequence[TouchFrame], script: Sequence[Line], surface: Surface) -> Scores:
    """Compare published frames with a script alone; its times count from the first frame.

    Steps: `target` with its `target_mm`, `hover` with its `height_mm`, `pressure` with its
    `force_g`. Touches outside every `target` step are ignored.
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
        confidence=Confidence(),
        timing=(),
        strikes=(),
        velocities=(),
        behaviour=Behaviour(),
        jumps=(),
        phrases=(),
    )


def _during(steps: Sequence[Line], frame: TouchFrame, start_us: int) -> Line | None:
    """Return the step that a frame belongs to."""
    seconds = (frame.time_us - start_us) / 1e6
    return next((step for step in steps if step["from_s"] <= seconds <= step["to_s"]), None)


def _contact(step: Line, start_us: int, surface: Surface) -> Line:
    """Return the truth's line of a touch that lasts as long as its step."""
    x, y = step["target_mm"]
    return {
        "contact": UNKNOWN_FINGER
        | {
            "from_us": start_us + round(1e6 * step["from_s"]),
            "to_us": start_us + round(1e6 * step["to_s"]),
            "camera_mm": surface.to_camera(np.array([[x, y, 0.0]]))[0].tolist(),
            "strike_mm_s": 0.0,
            "target_mm": [x, y],
        }
    }


def _frame(frame: TouchFrame, script: Sequence[Line], start_us: int, surface: Surface) -> Line:
    """Return a frame's line of truth: a finger at the script's level, at the lowest pointer."""
    step = _during([each for each in script if each.get("step") in LEVELS], frame, start_us)
    if step is None:
        return {"time_us": frame.time_us, "fingers": []}
    lowest = min(frame.pointers, key=lambda pointer: pointer.hover_mm, default=None)
    x, y = (lowest.x_mm, lowest.y_mm) if lowest else (0.0, 0.0)
    height_mm = float(step.get("height_mm", 0.0))
    finger = UNKNOWN_FINGER | {
        "camera_mm": surface.to_camera(np.array([[x, y, -height_mm]]))[0].tolist(),
        "height_mm": height_mm,
        "touching": False,
        "force_g": float(step.get("force_g", 0.0)),
    }
    return {"time_us": frame.time_us, "fingers": [finger]}
