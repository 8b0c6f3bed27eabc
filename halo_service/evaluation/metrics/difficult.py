"""Touches that are hard to see: flat and steep fingers, the surface's edge, a feint before each.

The feint is no touch, so a down that is told of it is a ghost. Whether what was told wrongly was
at least told unsurely is `sureness`'s to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.touches import Touches, pooled
from halo_service.evaluation.metrics.truth import Line, Truth

STEPS = {"angle": "pitch_deg", "edge": "beyond_mm"}
"""Step of the script -> the field that says how awkward it was."""


@dataclass(frozen=True, slots=True)
class Awkward:
    """One feint and the touch after it."""

    kind: str
    """Of STEPS."""
    value: float
    """Pitch in degrees, or mm beyond the edge, negative inside the surface."""
    touches: Touches
    """The true touch, hit or missed, and every other down told since the feint began."""


def score_awkward(touches: Touches, truth: Truth, script: Sequence[Line]) -> tuple[Awkward, ...]:
    """Return every pair that the script names; one whose touch no frame was taken of is none."""
    if not truth.frames:
        return ()
    start_us = truth.frames[0].time_us
    pairs = []
    for step in script:
        kind = step.get("step")
        if kind in STEPS and STEPS[kind] in step:
            begin, end = (start_us + 1e6 * step[side] for side in ("from_s", "to_s"))
            within = _within(touches, begin, end)
            if within.true:
                pairs.append(Awkward(kind, float(step[STEPS[kind]]), within))
    return tuple(pairs)


def by_value(pairs: Sequence[Awkward]) -> dict[tuple[str, float], Touches]:
    """Return the touches by kind and value, in order."""
    known = sorted({(pair.kind, pair.value) for pair in pairs})
    return {
        (kind, value): pooled([p.touches for p in pairs if (p.kind, p.value) == (kind, value)])
        for kind, value in known
    }


def _within(touches: Touches, begin_us: float, end_us: float) -> Touches:
    """Return what belongs to a stretch of time; the next step begins where one ends."""

    def during(time_us: int) -> bool:
        return begin_us <= time_us < end_us

    return Touches(
        tuple(hit for hit in touches.hits if during(hit.touch.from_us)),
        tuple(touch for touch in touches.missed if during(touch.from_us)),
        tuple(down for down in touches.doubled if during(down.time_us)),
        tuple(down for down in touches.outside if during(down.time_us)),
        tuple(down for down in touches.ghosts if during(down.time_us)),
    )
