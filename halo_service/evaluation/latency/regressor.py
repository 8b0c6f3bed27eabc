"""The paper's regressor itself, which the sequential order runs for every finger (4.3.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from halo_calibration.solvers.correction import Base, boosted
from halo_service.profile import Profile

LEAST_SAMPLES = 200
"""Fewer cannot fill trees of 31 leaves with 25 samples each."""
LEAST_EXPECTED = 0.05
"""As in the calibration: the least divisor."""


class Regressor:
    """Expected strength of a touch's halo at a place, one sample at a time."""

    def __init__(self, fitted: Any) -> None:
        """`fitted`: predicts from (N, 4) x, y in mm, pitch and yaw in degrees."""
        self._fitted = fitted

    def expect(self, x_mm: float, y_mm: float, pitch_deg: float, yaw_deg: float) -> float:
        """Return the relative signal, by the trees and not by a grid made of them."""
        place = np.array([[x_mm, y_mm, pitch_deg, yaw_deg]])
        return max(float(self._fitted.predict(place)[0]), LEAST_EXPECTED)


def regressor_for(profile: Profile, base: Base | None) -> Regressor | None:
    """Fit on the base's and the user's samples; None where there are too few of both.

    One model of 200 rounds, though the paper's is refined for each user: in its favour.
    """
    middle = np.array([profile.surface.width_mm / 2.0, profile.surface.height_mm / 2.0, 0.0, 0.0])
    where, signal = [np.empty((0, 4))], [np.empty(0)]
    if base is not None:
        where.append(base.relative[:, :4] + middle)
        signal.append(base.relative[:, 4])
    if profile.correction is not None and len(profile.correction.samples):
        samples = profile.correction.samples.astype(np.float64)
        where.append(samples[:, :4])
        signal.append(samples[:, 4] / np.median(samples[:, 4]))
    if sum(map(len, signal)) < LEAST_SAMPLES:
        return None
    return Regressor(boosted(np.concatenate(where), np.concatenate(signal)))
