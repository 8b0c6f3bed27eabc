"""How fast: a strike's speed against the finger's own, a pointer's velocity against the path's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from halo_service.evaluation.scores.levels import nearest
from halo_service.evaluation.scores.touches import Hit
from halo_service.evaluation.scores.truth import TrueFinger, TrueFrame, Truth
from halo_service.values import TouchFrame

MOVING_MM_S = 50.0
"""Chosen: a slower finger stands still, and a share of nothing says nothing."""
GAP_US = 50_000
"""Chosen: over a dropped frame the true path is not known well enough to derive."""
LEAST_FOR_RANKS = 5
"""Chosen: fewer have no order to speak of."""


@dataclass(frozen=True, slots=True)
class Speed:
    """One speed as it was told, and as it was."""

    told_mm_s: float
    true_mm_s: float
    off_mm_s: float
    """Length of the difference; for a velocity more than that of the two speeds."""


def score_strikes(hits: Sequence[Hit]) -> tuple[Speed, ...]:
    """Judge the approach speed of every touch that was told."""
    return tuple(
        Speed(told, true, abs(told - true))
        for told, true in ((hit.down.strike_mm_s, hit.touch.strike_mm_s) for hit in hits)
        if true > 0.0
    )


def score_velocity(frames: Sequence[TouchFrame], truth: Truth) -> tuple[Speed, ...]:
    """Judge the velocity in the plane of every pointer whose finger moves."""
    told_by = {frame.time_us: frame for frame in frames}
    speeds = []
    for frame, finger, (vx, vy) in _velocities(truth):
        true = float(np.hypot(vx, vy))
        told = told_by.get(frame.time_us)
        pointer = nearest(told.pointers, finger) if told else None
        if pointer is not None and true >= MOVING_MM_S:
            off = float(np.hypot(pointer.vx_mm_s - vx, pointer.vy_mm_s - vy))
            speeds.append(Speed(float(np.hypot(pointer.vx_mm_s, pointer.vy_mm_s)), true, off))
    return tuple(speeds)


def relative_error(speeds: Sequence[Speed]) -> float:
    """Median of how far off, as a share of the true speed; nan without any."""
    return float(np.median([s.off_mm_s / s.true_mm_s for s in speeds])) if speeds else np.nan


def rank_correlation(speeds: Sequence[Speed]) -> float:
    """Spearman's, told against true; nan for too few and where all were told alike."""
    told, true = [s.told_mm_s for s in speeds], [s.true_mm_s for s in speeds]
    if len(speeds) < LEAST_FOR_RANKS or np.ptp(told) == 0.0 or np.ptp(true) == 0.0:
        return np.nan
    return float(spearmanr(told, true).statistic)


def _velocities(truth: Truth) -> Iterator[tuple[TrueFrame, TrueFinger, tuple[float, float]]]:
    """Yield each finger with its velocity by the frames on both sides, mm/s."""
    for before, now, after in zip(truth.frames, truth.frames[1:], truth.frames[2:], strict=False):
        seconds = (after.time_us - before.time_us) / 1e6
        if seconds > 2e-6 * GAP_US:
            continue
        for finger in now.fingers:
            was = before.find(finger.side, finger.finger)
            will = after.find(finger.side, finger.finger)
            if was and will:
                velocity = ((will.x_mm - was.x_mm) / seconds, (will.y_mm - was.y_mm) / seconds)
                yield now, finger, velocity
