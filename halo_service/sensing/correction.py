"""Stage 5: what the signal would be at the place and angle of the calibration.

The paper (4.3.4) predicts the expected touch signal from tip position, pitch and yaw with a
gradient-boosted regressor. The calibration evaluates that regressor on a grid; here the grid is
interpolated, and the signal divided by the strength expected where the finger is.
"""

from __future__ import annotations

import numpy as np

from halo_service.profile import Correction
from halo_service.values import Fingertip

LEAST_STRENGTH, MOST_STRENGTH = 0.3, 3.0
"""No correction goes farther: beyond it the samples are wrong rather than the halo weak."""


def correct(raw: float, tip: Fingertip, correction: Correction | None) -> float:
    """Return the corrected signal, mm px; the raw one where no sweep was made."""
    if correction is None:
        return raw
    return raw / strength(correction, *tip.pad_mm, tip.pitch_deg, tip.yaw_deg)


def strength(
    correction: Correction, x_mm: float, y_mm: float, pitch_deg: float, yaw_deg: float
) -> float:
    """Return how strong a touch's halo is there, relative to the calibration's place and angle.

    Linear between the grid's points; outside the grid its edge goes on.
    """
    values = correction.strength
    for at, axis in zip(
        (x_mm, y_mm, pitch_deg, yaw_deg),
        (correction.x_mm, correction.y_mm, correction.pitch_deg, correction.yaw_deg),
        strict=True,
    ):
        first, step = float(axis[0]), float(axis[1] - axis[0])
        place = min(max((at - first) / step, 0.0), len(axis) - 1.0)
        low = min(int(place), len(axis) - 2)
        share = np.float32(place - low)
        values = values[low] + share * (values[low + 1] - values[low])
    return min(max(float(values), LEAST_STRENGTH), MOST_STRENGTH)
