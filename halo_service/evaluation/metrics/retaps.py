"""The touch point threshold: how far a finger must rise before its next touch is reported.

The paper averaged how far its participants' fingers travelled while they typed (5.3.4): that is
what people did, an upper bound of what the method needs. Here a finger lifts by chosen heights,
and the threshold is the smallest lift from which on nearly all re-taps are reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from halo_service.evaluation.metrics.touches import Touches
from halo_service.evaluation.metrics.truth import Line, Truth

ENOUGH = 0.99
"""Share of the re-taps."""


@dataclass(frozen=True, slots=True)
class Retap:
    """One touch that followed another on the same spot."""

    lift_mm: float
    """How far the finger rose between the two."""
    reported: bool


def score_retaps(touches: Touches, truth: Truth, script: Sequence[Line]) -> tuple[Retap, ...]:
    """Return every re-tap of the script: steps `retap` with their `lift_mm`."""
    if not truth.frames:
        return ()
    start_us = truth.frames[0].time_us
    hits = {hit.touch.from_us for hit in touches.hits}
    true = hits | {touch.from_us for touch in touches.missed}
    retaps = []
    for step in script:
        if step.get("step") == "retap":
            begin, end = (start_us + 1e6 * step[side] for side in ("from_s", "to_s"))
            within = [from_us for from_us in true if begin <= from_us <= end]
            retaps += [Retap(float(step["lift_mm"]), from_us in hits) for from_us in within]
    return tuple(retaps)


def reported_by_lift(retaps: Sequence[Retap]) -> dict[float, float]:
    """Return the share that was reported, by lift, in order."""
    lifts = sorted({retap.lift_mm for retap in retaps})
    return {lift: _share([r.reported for r in retaps if r.lift_mm == lift]) for lift in lifts}


def threshold_mm(retaps: Sequence[Retap]) -> float:
    """Return the smallest lift from which on at least ENOUGH are reported.

    Infinite where even the largest lift falls short; nan without re-taps.
    """
    shares = reported_by_lift(retaps)
    best = inf if shares else float("nan")
    for lift in sorted(shares, reverse=True):
        if shares[lift] < ENOUGH:
            break
        best = lift
    return best


def _share(reported: Sequence[bool]) -> float:
    return sum(reported) / len(reported)
