"""Stage 2: segmentation. What seems below the surface is halo, what is above it is hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.background import Part
from halo_service.sensing.finger_frame import FingerFrame, Pixel
from halo_service.sensing.settings import SensingSettings


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """A part of the image, segmented."""

    excess_mm: NDArray[np.float32]
    """(h, w) depth above the background, mm; 0 where unmeasured."""
    halo: NDArray[np.bool_]
    """(h, w) the surface seems dented here."""
    hand: NDArray[np.bool_]
    """(h, w) something is above the surface here."""
    free: NDArray[np.bool_]
    """(h, w) nothing is."""
    left: int = 0
    top: int = 0
    """The first column and row in the image."""

    @property
    def rows(self) -> slice:
        """Of the image."""
        return slice(self.top, self.top + self.hand.shape[0])

    @property
    def columns(self) -> slice:
        """Of the image."""
        return slice(self.left, self.left + self.hand.shape[1])

    def inside(self, image_px: Pixel) -> Pixel:
        """Return an image position in these arrays."""
        return image_px[0] - self.left, image_px[1] - self.top

    def within(self, place: FingerFrame) -> FingerFrame:
        """Return a finger's frame in these arrays."""
        return place._replace(tip_px=self.inside(place.tip_px))

    def cut(self, part: Part) -> Segmentation:
        """Return a part of this part; `part` in its own rows and columns."""
        return Segmentation(
            self.excess_mm[part],
            self.halo[part],
            self.hand[part],
            self.free[part],
            self.left + part[1].start,
            self.top + part[0].start,
        )


def segment(
    excess_mm: NDArray[np.float32],
    settings: SensingSettings,
    measured_mm: float,
    left: int = 0,
    top: int = 0,
) -> Segmentation:
    """Segment halo and hand by thresholds on the excess depth (paper 4.3.1).

    `measured_mm`: the threshold from the calibration; the settings may override it;
    `left`, `top`: the first column and row in the image.
    """
    halo = excess_mm > (settings.halo_threshold_mm or measured_mm)
    hand = excess_mm < -settings.hand_threshold_mm
    return Segmentation(excess_mm, halo, hand, ~hand, left, top)
