"""What the electronics add: noise, fixed pattern, drift, and pixels that read nothing.

Rule: images in, images out. Fresh normal numbers for a whole frame cost 20 ms, so they come from
a pool that is cut at a new random place each time.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.virtual.depth_image import Ideal
from halo_service.virtual.room import Room

Image = NDArray[np.float32]

FLOOR_MM = 0.5
"""Depth noise of a bright pixel, one sigma; chosen below what a real desk shows."""
PHOTON_MM = 0.85
PHOTON_IR = 700.0
"""Depth noise that an infrared of 700 adds, one sigma; it grows with 1 / sqrt(infrared). With the
floor: 0.98 mm at 700 and 2.1 mm at 120, where a public recording of a real desk shows 0.9 and,
texture included, 3.2."""
PATTERN_MM = 0.5
"""Fixed bias from pixel to pixel, one sigma; chosen within the data sheet's systematic error
(below 11 mm + 0.1 % of the distance)."""
WAVE_MM = 1.2
"""Fixed bias that changes slowly over the image; chosen likewise."""
DRIFT_MM, DRIFT_S = 2.0, 600.0
"""How much nearer everything reads when cold, and how it passes; chosen: published warm-ups of
the device move by about 2 mm within the first tens of minutes."""
IR_NOISE, IR_FLOOR = 0.035, 4.0
"""Of the brightness, and counts; a real desk shows about 5 % with its texture."""
TOO_DARK = 12.0
"""Below this many counts the device gives no depth; chosen."""
FIELD = 1.18
"""Radius of the illuminated circle in half image heights: the corners of the narrow field of
view read nothing (a public recording: about 340 px)."""
GRAIN = 2.0
"""Noise of the colour image, grey levels; chosen."""
_POOL = 1 << 21


class Electronics:
    """The noise of one device in one room."""

    def __init__(self, room: Room, lens: Lens) -> None:
        self._times = room.noise
        pool = np.random.default_rng([room.seed, 1])
        self._pool = pool.standard_normal(_POOL, np.float32)
        # The device is the same over all seeds: so is its fixed pattern.
        device = np.random.default_rng(0)
        shape = lens.height, lens.width
        wave = cv2.resize(
            device.normal(0.0, WAVE_MM, (5, 6)).astype(np.float32),
            (lens.width, lens.height),
            interpolation=cv2.INTER_CUBIC,
        )
        self._pattern = wave + device.normal(0.0, PATTERN_MM, shape).astype(np.float32)
        self._dark = _corners(lens)
        self._holes = room.surface_material.holes

    def depth(self, seen: Ideal, age_s: float, rng: np.random.Generator) -> NDArray[np.uint16]:
        """(H, W) uint16, mm, 0 where nothing is measured."""
        ideal, infrared = seen.depth, seen.infrared
        bright = np.maximum(infrared, np.float32(1.0))
        sigma = np.sqrt(np.float32(PHOTON_MM**2 * PHOTON_IR) / bright + np.float32(FLOOR_MM**2))
        sigma *= np.float32(self._times)
        sigma *= self._draw(ideal.shape, rng)
        drift = -DRIFT_MM * float(np.exp(-max(age_s, 0.0) / DRIFT_S))
        sigma += np.float32(drift + 0.5)  # 0.5: the cast below cuts, this rounds
        sigma += self._pattern
        sigma += ideal
        read: NDArray[np.uint16] = sigma.astype(np.uint16)
        read[self._dark | (infrared < TOO_DARK)] = 0
        if self._holes:
            holes = rng.random(ideal.shape, np.float32) < self._holes
            read[holes & (seen.covered == 0)] = 0
        return read

    def infrared(self, ideal: Image, rng: np.random.Generator) -> NDArray[np.uint16]:
        """(H, W) uint16 counts, 65535 where it saturates."""
        read = (ideal * np.float32(IR_NOISE) + np.float32(IR_FLOOR)) * self._draw(ideal.shape, rng)
        read += ideal
        return np.clip(read, 0.0, 65535.0).astype(np.uint16)

    def grain(self, image: NDArray[np.uint8], rng: np.random.Generator) -> None:
        """Add noise to a colour image, in place."""
        noise = self._draw((image.shape[0], image.shape[1]), rng)
        step = (noise * (GRAIN * self._times)).astype(np.int8)
        up, down = np.maximum(step, 0).astype(np.uint8), np.maximum(-step, 0).astype(np.uint8)
        cv2.add(image, cv2.merge([up, up, up]), dst=image)
        cv2.subtract(image, cv2.merge([down, down, down]), dst=image)

    def _draw(self, shape: tuple[int, ...], rng: np.random.Generator) -> Image:
        count = int(np.prod(shape))
        start = int(rng.integers(0, _POOL - count))
        cut = self._pool[start : start + count].reshape(shape)
        return cut if rng.random() < 0.5 else cut[::-1, ::-1]


def _corners(lens: Lens) -> NDArray[np.bool_]:
    """(H, W) what the illuminator does not reach."""
    rows, columns = np.mgrid[: lens.height, : lens.width]
    away = np.hypot(rows - lens.cy, columns - lens.cx)
    return np.asarray(away > FIELD * lens.height / 2.0, dtype=np.bool_)
