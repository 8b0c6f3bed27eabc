"""Depth while something moves: the mean over the pulses of one exposure.

Rule: images in, images out; the interior of a body hardly changes, its edges mix with what is
behind them.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.virtual.boxes import Box, grown
from halo_service.virtual.mesh import Ints

Image = NDArray[np.float32]

PULSES = 9
"""Exposures of the sensor in one frame (hardware specification)."""
EDGE_STEP_MM = 30.0
"""A step between front and back above which the device gives no depth for many pixels: the signal
is first lost at about 3 cm of finger height, then averaged (paper 4.1.3)."""
SHARP_PX = 1.0
"""Less movement than that within an exposure is not drawn."""
SURE = 0.1
"""Pixels that see a body for more than that share of the exposure, and less than the rest, change
between its pulses."""


def smear(
    before: tuple[Image, Image, Image],
    after: tuple[Image, Image, Image],
    covered: NDArray[np.uint8],
    moving: NDArray[np.uint8],
    pixel: Ints,
    streak_px: tuple[float, float],
) -> Box:
    """Expose images in which a body moves, in place; return where.

    `before` and `after`: (H, W) images without the body and with it, depth first; `pixel`: where
    it is, flat. `covered` is set where it mostly is; `moving` where it is for a part of the time,
    high over what is behind it.
    """
    kernel = _kernel(*streak_px)
    reach = max(kernel.shape) // 2
    mask = np.zeros(covered.shape, np.uint8)
    mask.ravel()[pixel] = 1
    x, y, width, height = cv2.boundingRect(mask)
    box = grown((slice(y, y + height), slice(x, x + width)), reach, None, mask.shape)
    body = mask[box].astype(np.float32)
    share = cv2.filter2D(body, -1, kernel, borderType=cv2.BORDER_REPLICATE)
    rows, columns = np.nonzero((share > 0.0) & (share < 1.0))
    here = share[rows, columns]
    lights = [
        cv2.filter2D(image[box] * body, -1, kernel, borderType=cv2.BORDER_REPLICATE)[rows, columns]
        for image in after
    ]
    backs = [image[box][rows, columns] for image in before]
    high = backs[0] * here - lights[0] > EDGE_STEP_MM * here
    for image, light, back in zip(after, lights, backs, strict=True):
        image[box][rows, columns] = back * (np.float32(1.0) - here) + light
    partly = high & (here > SURE) & (here < 1.0 - SURE)
    moving[box][rows[partly], columns[partly]] = 255
    covered[box][body > 0.0] = 0
    covered[box][share >= 0.5] = 255
    return box


def _kernel(dx: float, dy: float) -> Image:
    """Where the body is at each pulse, around the middle of the exposure."""
    reach = int(np.ceil(max(abs(dx), abs(dy)) / 2.0))
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), np.float32)
    for along in np.linspace(-0.5, 0.5, PULSES):
        kernel[reach + round(along * dy), reach + round(along * dx)] += 1.0 / PULSES
    return kernel
