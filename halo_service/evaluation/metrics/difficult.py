"""Touches that are difficult to see: flat or steep fingers, the edge, a feint before each.

The feint is no touch, so a down reported for it is a ghost. `confidence` measures whether wrong
reports at least have low confidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.touches import Touches
from halo_service.evaluation.metrics.truth import Line, Truth

STEPS = {"angle": "pitch_deg", "edge": "beyond_mm"}
"""Step of the script -> the field with its difficulty."""


@dataclass(frozen=True, slots=True)
class DifficultTouch:
    """One feint and the touch after it."""

    kind: str
    """A key of STEPS."""
    value: float
    """Pitch in degrees, or mm beyond the edge (negative: inside the surface)."""
    touches: Touches
    """The true touch, hit or missed, and every other down reported since the feint began."""


def score_difficult(
    touches: Touches, truth: Truth, script: Sequence[Line]
) -> tuple[DifficultTouch, ...]:
    """Return every feint and touch of the script; without touches that no frame shows."""
    if not truth.frames:
        return ()
    start_us = truth.frames[0].time_us
    found = []
    for step in script:
        kind = step.get("step")
        if kind in STEPS and STEPS[kind] in step:
            begin, end = (start_us + 1e6 * step[side] for side in ("from_s", "to_s"))
            within = _within(touches, begin, end)
            if within.true:
                found.append(DifficultTouch(kind, float(step[STEPS[kind]]), within))
    return tuple(found)


def _within(touches: Touches, begin_us: float, end_us: float) -> Touches:
    """Return what belongs to a time interval; the next step begins where one ends."""

    def during(time_us: int) -> bool:
        return begin_us <= time_us < end_us

    return Touches(
        tuple(hit for hit in touches.hits if during(hit.touch.from_us)),
        tuple(touch for touch in touches.missed if during(touch.from_us)),
        tuple(down for down in touches.doubled if during(down.time_us)),
        tuple(down for down in touches.outside if during(down.time_us)),
        tuple(down for down in touches.ghosts if during(down.time_us)),
    )
