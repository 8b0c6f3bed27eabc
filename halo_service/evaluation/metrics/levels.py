"""Hover and pressure: what is reported while a finger is held at a level, and what is true.

The paper took one reading per trial; the mean error over all frames of a trial is the expected
error of such a reading. A frame with no pointer near the finger gives no reading, nor does a
pointer without a force: the share of those is reported too, so that silence does not count as
accuracy.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from halo_service.evaluation.metrics.matching import Pair, match_pointers
from halo_service.evaluation.metrics.truth import Line, TrueFinger, TrueFrame, Truth
from halo_service.values import Finger, Pointer, Side, Touch, TouchFrame

FULL_G = 385.0
"""The paper's phone weighs no more (5.2.2); errors of force are shares of it."""
SMOOTH_MM = 3.0
"""Chosen: a finger that rises or sinks less than this from frame to frame moves smoothly."""
JUMPS_BELOW_MM = 60.0
"""Chosen: jumps are looked for below this, well past the halo's reach."""

Who = tuple[Side, Finger]
"""One finger of one hand."""

LEVELS = {"hover": "height_mm", "pressure": "force_g"}
"""Step of the script -> the field with its level."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One level, held once."""

    kind: str
    """`hover` or `pressure`."""
    level: float
    """mm or grams, as the script asks for."""
    error: float
    """Mean of the absolute errors, mm or % of FULL_G; nan where nothing was reported."""
    bias: float
    """Mean of the errors, likewise."""
    reported: float
    """Mean of what was reported, mm or grams."""
    no_reading: float
    """Share of the frames without a reading: no pointer near the finger, or no force."""


@dataclass(frozen=True, slots=True)
class Jump:
    """How much more hover changed from one frame to the next than the finger did."""

    height_mm: float
    """True, afterwards."""
    jump_mm: float


def score_levels(
    frames: Sequence[TouchFrame], truth: Truth, script: Sequence[Line]
) -> tuple[Trial, ...]:
    """Score every held level of the script."""
    if not frames:
        return ()
    start_us = truth.frames[0].time_us if truth.frames else frames[0].time_us
    return tuple(_trial(frames, truth, step, start_us) for step in script if _is_level(step))


def score_jumps(frames: Sequence[TouchFrame], truth: Truth) -> tuple[Jump, ...]:
    """Return a jump for each pair of successive frames in which a finger hovered smoothly."""
    jumps = []
    for before, after in pairwise(_followed(frames, truth)):
        for id_, (finger, pointer) in after.items():
            if id_ not in before or finger.height_mm > JUMPS_BELOW_MM:
                continue
            finger_before, pointer_before = before[id_]
            moved = finger.height_mm - finger_before.height_mm
            if abs(moved) < SMOOTH_MM and _hovers(pointer) and _hovers(pointer_before):
                reported = pointer.hover_mm - pointer_before.hover_mm
                jumps.append(Jump(finger.height_mm, abs(reported - moved)))
    return tuple(jumps)


def _is_level(step: Line) -> bool:
    return step.get("step") in LEVELS and LEVELS[step["step"]] in step


def _trial(frames: Sequence[TouchFrame], truth: Truth, step: Line, start_us: int) -> Trial:
    kind = step["step"]
    begin, end = start_us + 1e6 * step["from_s"], start_us + 1e6 * step["to_s"]
    within = [frame for frame in frames if begin <= frame.time_us <= end]
    trues = [truth.at(frame.time_us) for frame in within]
    level = float(step[LEVELS[kind]])
    who = _holder(kind, level, [true for true in trues if true is not None])
    found = [_pair(frame, true, who) for frame, true in zip(within, trues, strict=True)]
    readings = (_reading(kind, *pair) for pair in found if pair is not None)
    seen = [reading for reading in readings if reading is not None]
    no_reading = 1.0 - len(seen) / len(found) if found else 1.0
    if not seen:
        return Trial(kind, level, np.nan, np.nan, np.nan, no_reading)
    reported, true = np.array(seen).T
    error = (reported - true) * (100.0 / FULL_G if kind == "pressure" else 1.0)
    size, bias, mean = (float(each.mean()) for each in (np.abs(error), error, reported))
    return Trial(kind, level, size, bias, mean, no_reading)


def _holder(kind: str, level: float, trues: Sequence[TrueFrame]) -> Who | None:
    """Return the finger with the true height or force nearest to the level.

    Not the lowest finger: next to a finger held at 15 mm, half-curled ones hang lower.
    """
    away: dict[Who, list[float]] = {}
    for finger in (each for true in trues for each in true.fingers):
        held = finger.height_mm if kind == "hover" else finger.force_g
        away.setdefault((finger.side, finger.finger), []).append(abs(held - level))
    return min(away, key=lambda who: float(np.mean(away[who])), default=None)


def _pair(frame: TouchFrame, true: TrueFrame | None, who: Who | None) -> Pair | None:
    followed = match_pointers(frame, true)
    return next((pair for pair in followed if (pair[0].side, pair[0].finger) == who), None)


def _reading(kind: str, finger: TrueFinger, pointer: Pointer) -> tuple[float, float] | None:
    """Return the reported and the true value; None without a force."""
    if kind == "hover":
        return pointer.hover_mm, finger.height_mm
    if pointer.force_g < 0.0:
        return None
    return 0.0 if _hovers(pointer) else pointer.force_g, finger.force_g


def _hovers(pointer: Pointer) -> bool:
    return pointer.state is Touch.HOVER


def _followed(frames: Sequence[TouchFrame], truth: Truth) -> Iterator[dict[int, Pair]]:
    """Yield each frame's pointers by id, with the fingers that they follow."""
    for frame in frames:
        followed = match_pointers(frame, truth.at(frame.time_us))
        yield {pointer.id: (finger, pointer) for finger, pointer in followed}
