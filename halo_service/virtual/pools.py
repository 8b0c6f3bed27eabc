"""Random numbers for many images.

Rule: fresh ones for a whole frame cost 20 ms, so they come from pools: larger images that are cut
at a new random place, and turned over, each time.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]

SPARE = 400
"""How much larger a pool is than an image, px: so many places to cut it at, each way."""
SLOW_PX = 64
"""Size of the slow noise's waves, px; chosen: no trend is left over 24 px, and a plane takes most
of them out of a window of 72 px, as on the real recording."""


class Pool:
    """Random numbers, larger than an image."""

    def __init__(self, numbers: NDArray[Any], shape: tuple[int, int]) -> None:
        self._numbers, self._shape = numbers, shape

    def draw(self, rng: np.random.Generator) -> NDArray[Any]:
        """A view of as many numbers as an image has."""
        return self._numbers[self.place(rng, self._shape)]

    def place(self, rng: np.random.Generator, shape: tuple[int, ...]) -> tuple[slice, slice]:
        """Where to cut (rows, columns) out of it."""
        rows, columns = shape
        y = int(rng.integers(0, 1 + self._numbers.shape[0] - rows))
        x = int(rng.integers(0, 1 + self._numbers.shape[1] - columns))
        return slice(y, y + rows), slice(x, x + columns)


def boxed(white: Image, box_px: int) -> Image:
    """White noise through a box, of the same deviation."""
    if box_px == 1:
        return white
    smooth = cv2.blur(white, (box_px, box_px), borderType=cv2.BORDER_REFLECT)
    return np.asarray(smooth * np.float32(box_px), dtype=np.float32)


def waves(rng: np.random.Generator, shape: tuple[int, int]) -> Image:
    """Smooth noise of deviation 1."""
    rows, columns = shape
    coarse = rng.standard_normal((rows // SLOW_PX + 2, columns // SLOW_PX + 2), np.float32)
    smooth = cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC)
    return np.asarray(smooth / smooth.std(), dtype=np.float32)
