"""Stage 4: readings of the halo around one fingertip that hold for a halo of any shape.

Each is a number that grows as the finger comes down and presses; the calibration says how much each
is worth (`states`). The deepest square millimetres around the tip are found wherever they lie: a
fingertip found a millimetre off, or a halo that lies off the pad, reads the same.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Profile
from halo_service.sensing.extraction import extract
from halo_service.sensing.finger_frame import unit
from halo_service.sensing.scale import on_surface
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Fingertip

DEEPEST_MM2 = (100.0, 250.0)
"""The areas of the deepest surface that are averaged where all of it is visible: the rim of a
fingertip, and most of a halo that a finger leaves free (chosen)."""
FINGER_MM = (12.0, 11.0)
"""The finger itself hides the surface up to so far to its sides, and so far beyond the pad."""
AROUND_MM, BACK_MM = 25.0, 12.0
"""How far from the pad a halo reaches, and how far back along the finger (chosen)."""
PATCH_MM = (15.0, -3.0, 17.0)
"""Half the breadth of the paper's patch of 30 x 20 mm, and its ends along the finger (4.3.3)."""
EDGE = np.ones((3, 3), np.uint8)
"""A pixel next to a hand is not surface either: a camera averages along an edge."""
LEAST_VISIBLE = 0.3
"""Share of the surface around a fingertip: where less is visible, what is deepest there says little
about the halo (chosen)."""
LEAST_PX = 5
"""Fewer pixels are noise."""
NORMAL = NormalDist()

Floats = NDArray[np.float32]


class Around(NamedTuple):
    """What surrounds a fingertip, (h, w) each; lengths in mm of the surface."""

    excess_mm: Floats
    along: NDArray[np.float64]
    """From the pad, positive beyond the tip."""
    across: NDArray[np.float64]
    seen: NDArray[np.bool_]
    """Surface that the camera measured."""
    noise_mm: Floats
    """Of the empty surface."""


def around_pad(segmentation: Segmentation, tip: Fingertip, profile: Profile) -> Around | None:
    """Return what lies within `AROUND_MM` of the pad, None where the image ends before it."""
    scale = on_surface(profile)
    dx, dy = unit(tip.distal_px, tip.tip_px)
    pad_px = profile.surface.in_picture(np.array([tip.pad_mm]), profile.camera.depth, np.eye(4))
    x, y = segmentation.inside((float(pad_px[0, 0]), float(pad_px[0, 1])))
    reach = math.ceil(AROUND_MM * scale)
    left, top = max(round(x) - reach, 0), max(round(y) - reach, 0)
    window = np.s_[top : max(round(y) + reach + 1, 0), left : max(round(x) + reach + 1, 0)]
    excess_mm = segmentation.excess_mm[window]
    if excess_mm.size < LEAST_PX:
        return None
    right = (np.arange(left, left + excess_mm.shape[1]) - x) / scale
    down = (np.arange(top, top + excess_mm.shape[0]) - y)[:, None] / scale
    seen = cv2.erode(segmentation.free[window].astype(np.uint8), EDGE).astype(np.bool_)
    noise_mm = profile.background.noise_mm[segmentation.rows, segmentation.columns][window]
    return Around(
        excess_mm,
        right * dx + down * dy,
        down * dx - right * dy,
        seen & (excess_mm != 0.0),
        noise_mm,
    )


def readings(segmentation: Segmentation, tip: Fingertip, profile: Profile) -> tuple[float, ...]:
    """Return the sum over the patch, mm px, the deepest areas' mean depths and the patch's, mm.

    The depths are about 0 without a halo, nan where too little of the surface is visible.
    """
    total = extract(segmentation, tip)
    near = around_pad(segmentation, tip, profile)
    if near is None:
        return total, math.nan, math.nan, math.nan
    excess_mm, along, across, seen, noise_mm = near
    half, back, ahead = PATCH_MM
    reached = (along**2 + across**2 < AROUND_MM**2) & (along > -BACK_MM)
    beside = reached & ((np.abs(across) > FINGER_MM[0]) | (along > FINGER_MM[1]))
    visible = np.count_nonzero(seen & beside) / max(np.count_nonzero(beside), 1)
    if visible < LEAST_VISIBLE:
        return total, math.nan, math.nan, math.nan
    patch = excess_mm[seen & (np.abs(across) <= half) & (along > back) & (along <= ahead)]
    around = excess_mm[seen & reached]
    # Where other fingers hide half of a halo, half of its deep parts are visible.
    px_per_mm2 = visible * on_surface(profile) ** 2
    typical_mm = float(np.median(noise_mm))
    first, second = (_deepest(around, round(area * px_per_mm2), typical_mm) for area in DEEPEST_MM2)
    return total, first, second, float(patch.mean()) if patch.size >= LEAST_PX else math.nan


def _deepest(excess_mm: Floats, count: int, noise_mm: float) -> float:
    """Return the mean of the deepest pixels, less what noise alone makes of an even surface."""
    count = max(count, LEAST_PX)
    if excess_mm.size <= count:
        return math.nan
    share = count / excess_mm.size
    noise = noise_mm * NORMAL.pdf(NORMAL.inv_cdf(share)) / share
    return float(np.partition(excess_mm, -count)[-count:].mean()) - noise
