"""The touch point threshold: how far a finger must rise for its next touch to be told anew.

The paper averaged how far its participants' fingers travelled a key while they typed (5.3.4):
that is what people did, an upper bound of what the method needs. Here a finger is made to lift by
chosen heights, and the threshold is the smallest from which on nearly all re-taps are told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.touches import Touches
from halo_service.evaluation.metrics.truth import Line, Truth

ENOUGH = 0.99
"""Of the re-taps."""


@dataclass(frozen=True, slots=True)
class Retap:
    """One touch that followed another on the same spot."""

    lift_mm: float
    """How far the finger had risen between."""
    told: bool


def score_threshold(touches: Touches, truth: Truth, script: Sequence[Line]) -> tuple[Retap, ...]:
    """Return every re-tap that the script names: steps `retap` with their `lift_mm`."""
    if not truth.frames:
        return ()
    start_us = truth.frames[0].time_us
    told = {hit.touch.from_us for hit in touches.hits}
    true = told | {touch.from_us for touch in touches.missed}
    retaps = []
    for step in script:
        if step.get("step") == "retap":
            begin, end = (start_us + 1e6 * step[side] for side in ("from_s", "to_s"))
            within = [from_us for from_us in true if begin <= from_us <= end]
            retaps += [Retap(float(step["lift_mm"]), from_us in told) for from_us in within]
    return tuple(retaps)


def told_by_lift(retaps: Sequence[Retap]) -> dict[float, float]:
    """Return the share that was told, by lift, in order."""
    lifts = sorted({retap.lift_mm for retap in retaps})
    return {lift: _share([r.told for r in retaps if r.lift_mm == lift]) for lift in lifts}


def threshold_mm(shares: Mapping[float, float]) -> float | None:
    """Return the smallest lift from which on at least ENOUGH are told; None where none is."""
    best = None
    for lift in sorted(shares, reverse=True):
        if shares[lift] < ENOUGH:
            break
        best = lift
    return best


def _share(told: Sequence[bool]) -> float:
    return sum(told) / len(told)
