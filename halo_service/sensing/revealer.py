"""Stage 2: the halo revealer. What dents the surface is halo, what stands above it is hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.settings import SensingSettings


@dataclass(frozen=True, slots=True, eq=False)
class Revealed:
    """The scene, told apart."""

    excess_mm: NDArray[np.float32]
    """(H, W) depth above the background, mm; 0 where unmeasured."""
    halo: NDArray[np.bool_]
    """(H, W) the surface seems dented here."""
    hand: NDArray[np.bool_]
    """(H, W) something stands above the surface here."""
    free: NDArray[np.bool_]
    """(H, W) nothing does."""


def reveal(
    excess_mm: NDArray[np.float32], settings: SensingSettings, measured_mm: float
) -> Revealed:
    """Tell halo and hand apart by thresholds on the excess depth (paper 4.3.1).

    `measured_mm`: the threshold that the calibration found; the settings may say another.
    """
    halo = excess_mm > (settings.halo_threshold_mm or measured_mm)
    hand = excess_mm < -settings.hand_threshold_mm
    return Revealed(excess_mm, halo, hand, ~hand)
