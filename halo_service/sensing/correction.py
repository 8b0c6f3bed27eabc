"""Stage 5: what the signal would be at the place and angle of the calibration.

The paper (4.3.4) predicts the expected touch signal from tip position, pitch and yaw with a
gradient-boosted regressor. The calibration evaluates that regressor on a grid; here the grid is
interpolated, and the signal divided by the expected strength at the finger's place. Each reading
has its own smooth curve over the place, with its uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from halo_service.profile import Correction
from halo_service.profile.model import Floats
from halo_service.sensing.fingertips import plain_top_mm
from halo_service.values import Fingertip

UNSWEPT_TOP_MM = 2.5
"""Without a sweep, a finger's own depth differs by so much from place to place (chosen)."""


class Top(NamedTuple):
    """The upper side of a finger."""

    height_mm: float
    deviation_mm: float
    """Of one frame, by its place."""


def correct(raw: float, tip: Fingertip, correction: Correction | None) -> float:
    """Return the corrected signal, mm px; the raw one without a sweep."""
    if correction is None:
        return raw
    return raw / strength(correction, *tip.pad_mm, tip.pitch_deg, tip.yaw_deg)


def strength(
    correction: Correction, x_mm: float, y_mm: float, pitch_deg: float, yaw_deg: float
) -> float:
    """Return how strong a touch's halo is there, relative to the calibration's place and angle."""
    axes = (correction.x_mm, correction.y_mm, correction.pitch_deg, correction.yaw_deg)
    return float(_read(correction.strength, axes, (x_mm, y_mm, pitch_deg, yaw_deg)))


def leveled(
    read: Sequence[float], correction: Correction | None, x_mm: float, y_mm: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return readings as they would be at the calibration's place, and their relative deviations.

    There are no deviations without a sweep.
    """
    if correction is None or correction.readings is None or correction.deviations is None:
        return tuple(read), ()
    axes, at = (correction.x_mm, correction.y_mm), (x_mm, y_mm)
    grids = correction.readings, correction.deviations
    expected, deviations = (_read(each.transpose(1, 2, 0), axes, at).tolist() for each in grids)
    # Older states have fewer readings.
    values = tuple(each / usual for each, usual in zip(read, expected, strict=False))
    return values, tuple(deviations)


def higher(correction: Correction | None, x_mm: float, y_mm: float) -> tuple[float, float]:
    """Return how much higher an upper side reads there than at the calibration's place, mm.

    And the standard deviation of one frame around it.
    """
    if correction is None or correction.tops_mm is None:
        return 0.0, UNSWEPT_TOP_MM
    axes, grid = (correction.x_mm, correction.y_mm), correction.tops_mm.transpose(1, 2, 0)
    higher_mm, deviation_mm = _read(grid, axes, (x_mm, y_mm)).tolist()
    return higher_mm, deviation_mm


def leveled_top(tip: Fingertip, correction: Correction | None) -> Top:
    """Return the upper side at the calibration's place and at 45 degrees to the line of sight."""
    higher_mm, deviation_mm = higher(correction, *tip.pad_mm)
    return Top(plain_top_mm(tip.top_mm, tip.seen_deg) - higher_mm, deviation_mm)


def at_pitch(correction: Correction | None, pitch_deg: float) -> float:
    """Return what a pitch leaves of a touch's halo, relative to the calibration's."""
    if correction is None or correction.readings is None or correction.dent_by_pitch is None:
        return 1.0
    return float(_read(correction.dent_by_pitch, (correction.pitch_deg,), (pitch_deg,)))


def _read(grid: Floats, axes: Sequence[Floats], at: Sequence[float]) -> Floats:
    """Read a grid linearly between its points; outside, its edge values apply.

    `grid`: its first dimensions are the axes; returns the others, read at a place.
    """
    for place, axis in zip(at, axes, strict=True):
        first, step = float(axis[0]), float(axis[1] - axis[0])
        index = min(max((place - first) / step, 0.0), len(axis) - 1.0)
        low = min(int(index), len(axis) - 2)
        share = np.float32(index - low)
        grid = grid[low] + share * (grid[low + 1] - grid[low])
    return grid
