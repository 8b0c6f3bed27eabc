"""Stage 2: segmentation. What seems below the surface is halo, what is above it is hand."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Background
from halo_service.sensing.background import WHOLE, Part
from halo_service.sensing.finger_frame import FingerFrame, Pixel
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Infrared

DIFFERS, DIFFERS_SIGMAS = 0.15, 4.0
"""Infrared differs by more than this share of the empty surface's, and than so many of its standard
deviations (chosen: a finger's sides are darker by half and more)."""
FLAT_MM, AROUND_MM, LEAST_FLAT = 15.0, 60.0, 0.05
"""The level is the mean of what reads within so many mm of the surface, a dent included, in a
square of that side; with less than this share of it, all differs."""
BETWEEN_MM = 9.0
"""What is this narrow between two such sides is finger (chosen: the middle half of a finger as
bright as the surface)."""


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """A part of the image, segmented."""

    excess_mm: NDArray[np.float32]
    """(h, w) depth above the background, mm; 0 where unmeasured or hidden."""
    halo: NDArray[np.bool_]
    """(h, w) the surface seems dented here."""
    hand: NDArray[np.bool_]
    """(h, w) something is above the surface here."""
    free: NDArray[np.bool_]
    """(h, w) nothing is."""
    solid: NDArray[np.bool_]
    """(h, w) infrared shows something other than the surface; all False where it is unknown."""
    left: int = 0
    top: int = 0
    """The first column and row in the image."""
    share: NDArray[np.float32] | None = None
    """(h, w) probability that a pixel of the hand is this finger's; None: 1 everywhere."""
    hidden: NDArray[np.bool_] | None = None
    """(h, w) another finger is above this one here; all else is 0 or False. None: nowhere."""

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
        return FingerFrame(self.inside(place.tip_px), place.direction, place.px_per_mm)

    def cut(self, part: Part) -> Segmentation:
        """Return a part of this part; `part` in its own rows and columns."""
        return Segmentation(
            self.excess_mm[part],
            self.halo[part],
            self.hand[part],
            self.free[part],
            self.solid[part],
            self.left + part[1].start,
            self.top + part[0].start,
            None if self.share is None else self.share[part],
            None if self.hidden is None else self.hidden[part],
        )


def segment(
    excess_mm: NDArray[np.float32],
    settings: SensingSettings,
    measured_mm: float,
    solid: NDArray[np.bool_] | None = None,
    left: int = 0,
    top: int = 0,
) -> Segmentation:
    """Segment halo and hand by thresholds on the excess depth (paper 4.3.1), and by infrared.

    Skin reads too far, so the end of a touching finger reads like the surface or below it; its
    infrared still differs. `measured_mm`: the threshold from the calibration; the settings may
    override it; `solid`: see `infrared_silhouette`; `left`, `top`: the first column and row in the
    image.
    """
    if solid is None:
        solid = np.zeros(excess_mm.shape, np.bool_)
    hand = (excess_mm < -settings.hand_threshold_mm) | solid
    halo = (excess_mm > (settings.halo_threshold_mm or measured_mm)) & ~solid
    return Segmentation(excess_mm, halo, hand, ~hand, solid, left, top)


def infrared_silhouette(
    infrared: Infrared,
    background: Background,
    excess_mm: NDArray[np.float32],
    px_per_mm: float,
    part: Part = WHOLE,
) -> NDArray[np.bool_] | None:
    """Return (h, w) where infrared shows something other than the surface; None where unknown.

    A finger's sides are darker than any surface that faces the camera; what lies between them is
    finger too, though it may be as bright as the surface. `excess_mm`: of that `part`; a sheet that
    was laid on the surface since, or a lamp that warms up, changes the level that is expected.
    """
    if background.infrared is None or infrared.shape != background.infrared.shape:
        return None
    if excess_mm.size == 0:  # no finger is in the image
        return None
    share = infrared[part] / np.maximum(background.infrared[part], np.float32(1.0))
    least = np.float32(max(DIFFERS, DIFFERS_SIGMAS * background.infrared_noise))
    around_px = round(AROUND_MM * px_per_mm) | 1
    excluded = np.abs(excess_mm) > FLAT_MM
    level = _mean_around(share, ~excluded, around_px)
    # That level still holds the end of a touching finger.
    excluded |= np.abs(share - level) > least * level
    level = _mean_around(share, ~excluded, around_px)
    differs = np.abs(share - level) > least * level
    # A median of 3 x 3: in a mask that is where five or more of nine differ, and costs a quarter.
    near = cv2.boxFilter(
        differs.view(np.uint8), -1, (3, 3), normalize=False, borderType=cv2.BORDER_REPLICATE
    )
    clean = (near > 4).view(np.uint8)
    width_px = round(BETWEEN_MM * px_per_mm) | 1
    return np.asarray(
        cv2.morphologyEx(clean, cv2.MORPH_CLOSE, np.ones((width_px, width_px), np.uint8)) > 0
    )


def _mean_around(
    image: NDArray[np.float32], seen: NDArray[np.bool_], width_px: int
) -> NDArray[np.float32]:
    """Return the mean of what is seen in a square around each pixel."""
    size, least = (width_px, width_px), np.float32(LEAST_FLAT * width_px**2)
    count = cv2.boxFilter(seen.view(np.uint8), cv2.CV_32F, size, normalize=False)
    total = cv2.boxFilter(image * seen, cv2.CV_32F, size, normalize=False)
    return np.asarray(total / np.maximum(count, least), np.float32)
