"""Stage 1: how much farther each pixel reads than the empty surface did."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Background
from halo_service.values import Depth

Part = tuple[slice, slice]
"""Rows and columns of an image."""
WHOLE: Part = (slice(None), slice(None))
DRIFT_STEP = 16
DRIFT_GRID: Part = (slice(None, None, DRIFT_STEP), slice(None, None, DRIFT_STEP))
"""Every sixteenth pixel in both directions gives the drift to 0.1 mm, before smoothing."""
DRIFT_REACH_MM = 15.0
"""What differs by more is hand, halo or an object on the table, and is not used for the drift."""
DRIFT_TIME_S = 10.0
"""Time constant of the drift: slower than any hand, faster than a device that warms up."""


def excess_depth(
    depth: Depth, background: Background, drift_mm: float = 0.0, part: Part = WHOLE
) -> NDArray[np.float32]:
    """Return (h, w) float32, mm: positive where it reads farther than the surface, negative nearer.

    0 where either measured nothing: a pixel without depth is neither hand nor halo.
    `drift_mm`: how much farther the whole device reads than when the background was captured;
    `part`: of the image, because the whole image costs more than all the fingers in it.
    """
    excess = depth[part].astype(np.float32)
    measured = np.logical_and(excess, background.valid[part])
    excess -= background.mean_mm[part]
    excess -= np.float32(drift_mm)
    excess *= measured
    return excess


@lru_cache(maxsize=4)
def thinned(background: Background, step: int) -> Background:
    """Return every `step`-th pixel of a background, in both directions.

    It is read in each frame. As an array of its own it is read faster than across whole images.
    """
    grid = np.s_[::step, ::step]
    mean_mm, noise_mm, valid = (
        np.ascontiguousarray(each[grid])
        for each in (background.mean_mm, background.noise_mm, background.valid)
    )
    return Background(mean_mm, noise_mm, valid)


@dataclass(frozen=True, slots=True)
class Drift:
    """How much farther the whole device reads than when the background was captured."""

    offset_mm: float = 0.0
    time_us: int | None = None
    """When it was last updated; None before the first frame."""


def follow_drift(before: Drift, depth: Depth, background: Background, time_us: int) -> Drift:
    """Advance the device's drift by one frame.

    The background itself is never adapted: that would remove the halo. A device that warms up
    shifts all pixels equally, so the median of the pixels that show only surface is its drift.
    """
    elapsed_us = 0 if before.time_us is None else max(time_us - before.time_us, 0)
    seen, empty = depth[DRIFT_GRID], thinned(background, DRIFT_STEP)
    off_mm = seen - empty.mean_mm - np.float32(before.offset_mm)
    surface = off_mm[np.logical_and(seen, empty.valid) & (np.abs(off_mm) < DRIFT_REACH_MM)]
    if surface.size == 0:
        return Drift(before.offset_mm, time_us)
    share = 1.0 - math.exp(-elapsed_us / (1e6 * DRIFT_TIME_S))
    return Drift(before.offset_mm + share * float(np.median(surface)), time_us)
