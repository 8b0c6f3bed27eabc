"""A long nail: the outline ends with it, but the pad and the halo around it are farther back.

The camera cannot tell a nail from skin. The halo can: at the sides of a touching finger it is
deepest near the pad. Calibration measures how far back that is, and the reported place is moved by
it. The halo's readings and their correction stay at the outline's end, in calibration and after it.
"""

from __future__ import annotations

import math

import numpy as np

from halo_service.profile import Profile
from halo_service.sensing.fingertips import TIP_RADIUS_MM
from halo_service.sensing.readings import LEAST_PX, around_pad
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Fingertip

BEHIND_MM, AHEAD_MM = 22, 14
"""Where along the finger the halo is read, from the pad of a finger without a nail."""
BESIDE_MM = 7.0
"""And how far to both sides of the finger."""
DEEPEST_SHARE = 0.7
"""The middle of all that is so deep is where the halo is deepest: one peak alone is noise."""
WINDOW = np.ones(5)
"""The halo is averaged over so many mm: three pixels at a metre."""


def halo_behind_mm(segmentation: Segmentation, tip: Fingertip, profile: Profile) -> float:
    """Return how far behind the pad the halo at a finger's sides is deepest, mm; nan if hidden.

    `tip`: located as if it had no long nail.
    """
    near = around_pad(segmentation, tip, profile)
    if near is None:
        return math.nan
    radius_mm = tip.width_mm / 2.0 if math.isfinite(tip.width_mm) else TIP_RADIUS_MM
    aside = np.abs(near.across) - radius_mm
    seen = near.seen & (aside > 0.0) & (aside < BESIDE_MM)
    seen &= (near.along > -BEHIND_MM) & (near.along < AHEAD_MM)
    place = (near.along[seen] + BEHIND_MM).astype(np.intp)
    excess_mm = np.maximum(near.excess_mm[seen], 0.0)
    steps = BEHIND_MM + AHEAD_MM
    count, total = (
        np.convolve(np.bincount(place, each, minlength=steps), WINDOW, "same")
        for each in (None, excess_mm)
    )
    depth_mm = np.where(count >= LEAST_PX, total / np.maximum(count, 1.0), 0.0)
    weight = np.where(depth_mm > DEEPEST_SHARE * depth_mm.max(), depth_mm, 0.0)
    if not weight.any():
        return math.nan
    along = np.arange(steps) + 0.5 - BEHIND_MM
    return -float(weight @ along / weight.sum())


def pad_under_nail(
    pad_mm: tuple[float, float], pitch_deg: float, yaw_deg: float, nail_mm: float
) -> tuple[float, float]:
    """Return where the pad is on the surface, mm, of a finger with such a nail.

    `pad_mm`: located as if it had none.
    """
    yaw, back = math.radians(yaw_deg), nail_mm * math.cos(math.radians(pitch_deg))
    return pad_mm[0] - back * math.sin(yaw), pad_mm[1] + back * math.cos(yaw)
