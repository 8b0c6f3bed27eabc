"""How fast: a strike's reported speed and the finger's own, a pointer's velocity and the path's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from halo_service.evaluation.metrics.matching import match_pointers
from halo_service.evaluation.metrics.touches import Hit
from halo_service.evaluation.metrics.truth import TrueFrame, Truth
from halo_service.values import Finger, Side, TouchFrame

MOVING_MM_S = 50.0
"""Chosen: a slower finger does not move, and a share of nothing has no meaning."""
GAP_US = 50_000
"""Chosen: over a dropped frame the true path is not known well enough to differentiate."""
LEAST_FOR_RANKS = 5
"""Chosen: fewer values have no meaningful order."""

Velocity = tuple[float, float]
"""In the plane, mm/s, surface frame."""


@dataclass(frozen=True, slots=True)
class Speed:
    """One reported speed and the true one."""

    reported_mm_s: float
    true_mm_s: float
    error_mm_s: float
    """Length of the difference; for a velocity more than that of the two speeds."""


def score_strikes(hits: Sequence[Hit]) -> tuple[Speed, ...]:
    """Compare the approach speed of every touch that was reported."""
    return tuple(
        Speed(reported, true, abs(reported - true))
        for reported, true in ((hit.down.strike_mm_s, hit.touch.strike_mm_s) for hit in hits)
        if true > 0.0
    )


def score_velocity(frames: Sequence[TouchFrame], truth: Truth) -> tuple[Speed, ...]:
    """Compare the velocity in the plane of every pointer with a moving finger."""
    by_time = {frame.time_us: frame for frame in frames}
    return tuple(
        _speed((pointer.vx_mm_s, pointer.vy_mm_s), true)
        for now, velocities in _velocities(truth)
        for finger, pointer in match_pointers(by_time.get(now.time_us), now)
        if (true := velocities.get((finger.side, finger.finger))) and np.hypot(*true) >= MOVING_MM_S
    )


def relative_error(speeds: Sequence[Speed]) -> float:
    """Median error as a share of the true speed; nan without any."""
    return float(np.median([s.error_mm_s / s.true_mm_s for s in speeds])) if speeds else np.nan


def rank_correlation(speeds: Sequence[Speed]) -> float:
    """Spearman's, reported and true; nan for too few and where all are alike."""
    reported, true = [s.reported_mm_s for s in speeds], [s.true_mm_s for s in speeds]
    if len(speeds) < LEAST_FOR_RANKS or np.ptp(reported) == 0.0 or np.ptp(true) == 0.0:
        return np.nan
    return float(spearmanr(reported, true).statistic)


def _speed(reported: Velocity, true: Velocity) -> Speed:
    error = np.hypot(reported[0] - true[0], reported[1] - true[1])
    return Speed(float(np.hypot(*reported)), float(np.hypot(*true)), float(error))


def _velocities(truth: Truth) -> Iterator[tuple[TrueFrame, dict[tuple[Side, Finger], Velocity]]]:
    """Yield each frame with its fingers' velocities, from the frames before and after it."""
    for before, now, after in zip(truth.frames, truth.frames[1:], truth.frames[2:], strict=False):
        seconds = (after.time_us - before.time_us) / 1e6
        if seconds > 2e-6 * GAP_US:
            continue
        moving = {}
        for side, finger in ((each.side, each.finger) for each in now.fingers):
            was, will = before.find(side, finger), after.find(side, finger)
            if was and will:
                way = (will.x_mm - was.x_mm, will.y_mm - was.y_mm)
                moving[side, finger] = (way[0] / seconds, way[1] / seconds)
        yield now, moving
