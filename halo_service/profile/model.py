"""A profile: the empty surface, where it lies, and how a finger's halo reads on it.

Rule: frozen values. `store` keeps them on disk, `fit` makes them from measurements.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface

Calibrated = Literal["none", "partial", "complete"]


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """The empty surface, pixel by pixel."""

    mean_mm: NDArray[np.float32]
    """(H, W) mean depth."""
    noise_mm: NDArray[np.float32]
    """(H, W) standard deviation over the frames."""
    valid: NDArray[np.bool_]
    """(H, W) True where enough frames had a measurement."""


@dataclass(frozen=True, slots=True)
class HeldState:
    """One of the four states the user held still."""

    signal: float
    """Median halo signal while it was held, mm px."""
    height_mm: float
    """Height of the pad as stated; 0 in contact."""
    force_g: float
    """Force as stated; 0 in the air, -1 in contact when unknown."""


@dataclass(frozen=True, slots=True)
class TouchStates:
    """The four states of the paper's first calibration task (section 4.3.5)."""

    hover: HeldState
    subtle: HeldState
    touch: HeldState
    pressure: HeldState
    line_px_at_hover: float
    """Halo pixels on the finger's line in the hover state."""
    finger_thickness_mm: float
    """Height of the finger's upper side above the surface while its pad touches."""


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """One place and user."""

    name: str
    camera: Camera
    """The camera it was made with; it fits no other."""
    surface: Surface
    background: Background
    touch: TouchStates | None
    """None before the touch step was done."""
    revision: int
    """Grows with every change."""

    @property
    def calibrated(self) -> Calibrated:
        """`complete` when touches can be read with it."""
        return "partial" if self.touch is None else "complete"
