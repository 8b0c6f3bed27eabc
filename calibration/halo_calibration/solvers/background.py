"""The empty surface: its mean, its noise, and where it can be measured. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.errors import CalibrationError
from halo_calibration.image_places import largest
from halo_service.profile import Background
from halo_service.values import Depth, Infrared

WANTED_FRAMES = 60
"""The paper's background is the mean of 60 frames (section 4.3.1)."""
LEAST_FRAMES = 45
"""As many good frames suffice: a few may be dropped."""
GOOD_FRACTION = 0.75
"""A pixel is valid with 45 good frames of 60: mixed pixels at edges come and go."""
BLOCK_PX = 8
"""Movement is sought in blocks of 8 x 8 pixels: one pixel's noise is no movement."""
MOVED_MM = 4.0
"""Between the first and the last third a still block's mean moves by less (noise is 1 mm a pixel,
0.03 mm a block and third; the rest is for a device that warms up or a table that is bumped)."""
NOISY_MM = 8.0
"""A still pixel's standard deviation is less, except at edges and in the dark."""
GONE = 0.5
"""A still pixel is measured in shares of the two thirds' frames that differ by less: in the dark at
the rim of the lit circle it is there in some frames and not in others."""
MOVED_BLOCKS = 3
"""Blocks in a row that make a movement: two fingers' width."""
THRESHOLD_SIGMAS, THRESHOLD_MM = 5.0, (4.0, 10.0)
"""A pixel is halo when it departs by so many standard deviations; the bounds are those of the
paper (4.3.1: 5 to 10 by placement and material), the lower one a little below."""


def solve_background(depths: Sequence[Depth], infrareds: Sequence[Infrared] = ()) -> Background:
    """Average depth frames of the empty surface.

    `depths`: (H, W) uint16 mm, 0 = unmeasured; unmeasured values count for nothing;
    `infrareds`: (H, W) of the same frames, if there is infrared.
    Raises `CalibrationError` for too few frames, or where something moved, saying where.
    """
    if len(depths) < LEAST_FRAMES:
        raise CalibrationError(
            f"only {len(depths)} of the {WANTED_FRAMES} frames of the empty surface came, and "
            f"{LEAST_FRAMES} are needed: the camera dropped frames; plug it into a USB 3 port of "
            f"its own, close other programs, and take the background again"
        )
    background = average(depths)
    third = len(depths) // 3
    moved = _moved(background, depths[:third], depths[-third:])
    size, place = largest(moved)
    if size >= MOVED_BLOCKS:
        share = 100.0 * size / moved.size
        raise CalibrationError(
            f"something moved {place} of the picture while the background was taken (about "
            f"{share:.0f} % of it): keep hands and people out of the camera's view, and take it "
            f"again"
        )
    there = bool(infrareds) and all(each.shape == depths[0].shape for each in infrareds)
    return _with_infrared(background, infrareds) if there else background


def _with_infrared(background: Background, infrareds: Sequence[Infrared]) -> Background:
    """Return the background with the mean of its infrared and its typical noise."""
    total, squares = (np.zeros(background.valid.shape, np.float64) for _ in range(2))
    for infrared in infrareds:
        cv2.accumulate(infrared, total)
        cv2.accumulateSquare(infrared, squares)
    mean = total / len(infrareds)
    seen = background.valid & (mean > 0.0)
    if not seen.any():
        return background  # such as a recording without infrared
    variance = np.maximum(squares[seen] / len(infrareds) - mean[seen] ** 2, 0.0)
    noise = float(np.median(np.sqrt(variance) / mean[seen]))
    return replace(background, infrared=mean.astype(np.float32), infrared_noise=noise)


def average(depths: Sequence[Depth]) -> Background:
    """Return mean and standard deviation of each pixel over one frame or more."""
    count = np.zeros(depths[0].shape, np.float64)
    total, squares = np.zeros_like(count), np.zeros_like(count)
    for depth in depths:
        value = depth.astype(np.float64)
        count += depth > 0
        total += value
        cv2.accumulateSquare(value, squares)
    seen = np.maximum(count, 1.0)
    mean = total / seen
    variance = np.maximum(squares / seen - mean * mean, 0.0)
    valid = count >= max(1.0, GOOD_FRACTION * len(depths))
    return Background(mean.astype(np.float32), np.sqrt(variance).astype(np.float32), valid)


def halo_threshold(background: Background) -> float:
    """Return the excess depth in mm from which a pixel is halo on this surface."""
    noise = background.noise_mm[background.valid]
    typical = float(np.median(noise)) if noise.size else THRESHOLD_MM[1]
    return round(float(np.clip(THRESHOLD_SIGMAS * typical, *THRESHOLD_MM)), 1)


def _moved(whole: Background, first: Sequence[Depth], last: Sequence[Depth]) -> NDArray[np.bool_]:
    """Return the blocks in which something moved, (H / 8, W / 8).

    `first`, `last`: of the frames of the whole background.
    """
    before, after = average(first), average(last)
    both = before.valid & after.valid
    shift = np.where(both, after.mean_mm - before.mean_mm, 0.0)
    seen = _blocks(both.astype(np.float64)).sum(axis=(1, 3))
    mean_shift = _blocks(shift).sum(axis=(1, 3)) / np.maximum(seen, 1.0)
    half = BLOCK_PX * BLOCK_PX / 2
    shifted = (seen >= half) & (np.abs(mean_shift) > MOVED_MM)
    # A hand that passed in between, or pixels that were seen at one end only.
    noisy = _blocks((whole.noise_mm > NOISY_MM) & (whole.mean_mm > 0)).sum(axis=(1, 3)) > half
    gone = _blocks(np.abs(_measured(last) - _measured(first)) > GONE).sum(axis=(1, 3)) > half
    return np.asarray(shifted | noisy | gone)


def _measured(depths: Sequence[Depth]) -> NDArray[np.float64]:
    """Return the share of the frames in which each pixel is measured."""
    return np.asarray(np.mean([depth > 0 for depth in depths], axis=0))


def _blocks(image: NDArray[np.generic]) -> NDArray[np.generic]:
    """View (H, W) as (H / 8, 8, W / 8, 8), leaving out what is left over."""
    height, width = (size - size % BLOCK_PX for size in image.shape)
    return image[:height, :width].reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX)
