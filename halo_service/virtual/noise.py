"""What the electronics add: noise, fixed pattern, drift, and pixels that read nothing.

Rule: images in, images out; random numbers come from `pools`.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera, Lens
from halo_service.virtual.boxes import Box
from halo_service.virtual.camera import MODES, px_times
from halo_service.virtual.depth_image import Ideal
from halo_service.virtual.pools import SPARE, Pool, boxed, waves
from halo_service.virtual.room import Room
from halo_service.virtual.sensor_model import SensorModel

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
DRIFT_MM = 2.0
"""How much nearer everything reads when cold; chosen: published warm-ups of the device move by
about 2 mm."""
IR_NOISE, IR_FLOOR = 0.035, 4.0
"""Of the brightness, and counts; a real desk shows about 5 % with its texture."""
TOO_DARK = 12.0
"""Below this many counts the device gives no depth; chosen."""
GRAIN = 2.0
"""Noise of the colour image, grey levels; chosen."""
_BAND_ROWS = 64
"""An image is read in parts that stay in the processor's cache from one step to the next."""
_COLOUR_ROWS, _COLOUR_COLUMNS = 720, 1280


class Electronics:
    """The noise of one device in one room."""

    def __init__(self, room: Room, camera: Camera, empty: Ideal) -> None:
        """`empty`: the room without hands."""
        lens, model = camera.depth, room.sensor
        self._times, self._model = np.float32(room.noise), model
        shape = lens.height, lens.width
        size = shape[0] + SPARE, shape[1] + SPARE
        rng = np.random.default_rng([*room.noise_seed, 1])
        # The colour image draws from it too.
        most = max(size[0], _COLOUR_ROWS + SPARE), max(size[1], _COLOUR_COLUMNS + SPARE)
        white = rng.standard_normal(most, np.float32)
        self._white = Pool(white, shape)
        step = (white * np.float32(GRAIN * self._times)).astype(np.int8)
        self._brighter, self._darker = (
            np.maximum(sign, 0).astype(np.uint8) for sign in (step, -step)
        )
        part = white[: size[0], : size[1]]
        self._photons = Pool(np.float32(1.0) + np.float32(IR_NOISE) * part, shape)
        # 0.5: a device cuts; the sum in `infrared` rounds.
        self._counts = Pool(np.float32(IR_FLOOR) * part - np.float32(0.5), shape)
        self._correlated = Pool(boxed(part, model.noise_box_px), shape)
        self._slow = Pool(waves(rng, size), shape)
        dark = TOO_DARK + model.dark_flicker_counts * rng.standard_exponential(size, np.float32)
        self._too_dark = Pool(np.ceil(_in_steps(dark)).astype(np.uint16), shape)
        self._pattern = _fixed_pattern(lens, room.installation.camera - 1)
        self._seen = _most_counts(_flicker(lens, MODES[camera.depth_mode].field, model), model)
        self._holes = room.surface_material.holes
        self.furnish(empty)

    def furnish(self, empty: Ideal) -> None:
        """Expect another empty room: only where a frame differs from it there is more to do."""
        self._empty = self._before_noise(empty, _everywhere(empty.depth))

    def depth(
        self, seen: Ideal, changed: Box | None, age_s: float, rng: np.random.Generator
    ) -> NDArray[np.uint16]:
        """(H, W) uint16, mm, 0 where nothing is measured.

        `changed`: where it may differ from the empty room.
        """
        noise = self._drawn(age_s, rng)
        read = self.empty_depth(noise)
        if changed is not None:
            read[changed] = noise.read(self._before_noise(seen, changed), changed)
        if self._holes:
            gone = rng.random(read.shape, np.float32) < self._holes
            read[gone & (seen.covered == 0)] = 0
        return read

    def empty_depth(self, noise: DepthNoise) -> NDArray[np.uint16]:
        """(H, W) uint16, mm, of the empty room."""
        read: NDArray[np.uint16] = np.empty(self._empty.depth.shape, np.uint16)
        for band in _bands(read.shape[0]):
            read[band] = noise.read(self._empty.rows(band), (band, slice(None)))
        return read

    def _drawn(self, age_s: float, rng: np.random.Generator) -> DepthNoise:
        """The depth noise of a frame."""
        drift = -DRIFT_MM * float(np.exp(-max(age_s, 0.0) / self._model.warm_up_s))
        return DepthNoise(
            self._correlated.draw(rng),
            self._turned(rng),
            self._slow.draw(rng),
            self._turned(rng) * self._model.slow_noise_mm,
            self._too_dark.draw(rng),
            drift,
        )

    def _before_noise(self, seen: Ideal, box: Box) -> _Quiet:
        infrared = seen.infrared[box]
        deviation: Image = np.float32(PHOTON_MM**2 * PHOTON_IR) / infrared
        deviation += np.float32(FLOOR_MM**2)
        return _Quiet(
            np.asarray(seen.depth[box] + self._pattern[box], np.float32),
            np.asarray(cv2.sqrt(deviation), np.float32),
            _in_steps(np.minimum(infrared, self._seen[box])).astype(np.uint16),
        )

    def _turned(self, rng: np.random.Generator) -> float:
        """The room's share of the noise, of either sign: what is drawn twice stays independent."""
        return (-1.0, 1.0)[rng.integers(2)] * float(self._times)

    def infrared(self, seen: Ideal, rng: np.random.Generator) -> NDArray[np.uint16]:
        """(H, W) uint16 counts, 65535 where it saturates."""
        return self.infrared_noise(rng).whole(seen.infrared)

    def infrared_noise(self, rng: np.random.Generator) -> InfraredNoise:
        """The infrared noise of a frame."""
        return InfraredNoise(self._photons.draw(rng), self._counts.draw(rng))

    def grain(self, image: NDArray[np.uint8], rng: np.random.Generator) -> None:
        """Add noise to a colour image, in place."""
        cut = self._white.place(rng, image.shape[:2])
        cv2.add(image, cv2.merge([self._brighter[cut]] * 3), dst=image)
        cv2.subtract(image, cv2.merge([self._darker[cut]] * 3), dst=image)


@dataclass(frozen=True, slots=True, eq=False)
class _Quiet:
    """A part of the depth image without noise, and how much of that there is."""

    depth: Image
    """mm that are read in the mean."""
    deviation: Image
    """mm."""
    seen: NDArray[np.uint16]
    """Infrared by which depth is readable, in steps of 1/128 count."""

    def rows(self, rows: slice) -> _Quiet:
        return _Quiet(self.depth[rows], self.deviation[rows], self.seen[rows])


@dataclass(frozen=True, slots=True, eq=False)
class DepthNoise:
    """What one frame draws for its depth."""

    white: Image
    white_times: float
    slow: Image
    slow_times: float
    too_dark: NDArray[np.uint16]
    drift_mm: float

    def read(self, quiet: _Quiet, box: Box) -> NDArray[np.uint16]:
        """What a part of the image reads."""
        read = cv2.multiply(quiet.deviation, self.white[box])
        # 0.5: the cast below cuts, this rounds.
        cv2.addWeighted(read, self.white_times, quiet.depth, 1.0, self.drift_mm + 0.5, dst=read)
        cv2.scaleAdd(self.slow[box], self.slow_times, read, dst=read)
        valid = cv2.compare(quiet.seen, self.too_dark[box], cv2.CMP_GE)
        return np.asarray(cv2.copyTo(np.asarray(read, np.uint16), valid), dtype=np.uint16)


@dataclass(frozen=True, slots=True, eq=False)
class InfraredNoise:
    """What one frame draws for its infrared."""

    photons: Image
    counts: Image

    def read(self, light: Image, box: Box) -> NDArray[np.uint16]:
        """What a part of the image reads."""
        noisy = cv2.multiply(light, self.photons[box])
        read = cv2.add(noisy, self.counts[box], dtype=cv2.CV_16U)
        return np.asarray(read, dtype=np.uint16)

    def whole(self, light: Image) -> NDArray[np.uint16]:
        """What an image reads."""
        read: NDArray[np.uint16] = np.empty(light.shape, np.uint16)
        for band in _bands(len(read)):
            read[band] = self.read(light[band], (band, slice(None)))
        return read


def _in_steps(counts: Image) -> Image:
    """Infrared in steps of 1/128 count, for 16 bits: what is brighter is readable for certain."""
    return np.asarray(np.float32(128.0) * np.minimum(counts, np.float32(511.0)), dtype=np.float32)


def _everywhere(image: Image) -> Box:
    return slice(0, image.shape[0]), slice(0, image.shape[1])


def _bands(rows: int) -> list[slice]:
    """An image in parts that stay in the processor's cache from one step to the next."""
    return [slice(row, min(row + _BAND_ROWS, rows)) for row in range(0, rows, _BAND_ROWS)]


def _fixed_pattern(lens: Lens, number: int) -> Image:
    """A device is the same over all seeds: so is its fixed pattern. `number`: from 0."""
    device = np.random.default_rng(number)
    coarse = device.normal(0.0, WAVE_MM, (5, 6)).astype(np.float32)
    wave = cv2.resize(coarse, (lens.width, lens.height), interpolation=cv2.INTER_CUBIC)
    pixels = device.normal(0.0, PATTERN_MM, (lens.height, lens.width))
    return np.asarray(wave + pixels, dtype=np.float32)


def _flicker(lens: Lens, field: float, model: SensorModel) -> Image:
    """(H, W) chance that a pixel reads 0 in a frame; 1 where the illuminator does not reach."""
    rows, columns = np.mgrid[: lens.height, : lens.width]
    beyond = np.hypot(rows - lens.cy, columns - lens.cx) - field * lens.height / 2.0
    soft_px = model.rim_flicker_px * px_times(lens)
    if soft_px == 0.0:
        return np.asarray(beyond > 0.0, dtype=np.float32)
    rim = 1.0 / (1.0 + np.exp(np.clip(-beyond / soft_px, -50.0, 50.0)))
    return np.asarray(model.flicker + (1.0 - model.flicker) * rim, dtype=np.float32)


def _most_counts(chance: Image, model: SensorModel) -> Image:
    """(H, W) infrared that reads 0 with a chance: no pixel is more sure than that."""
    if model.dark_flicker_counts == 0.0:
        return np.where(chance < 0.5, np.float32(np.inf), np.float32(0.0))
    counts = TOO_DARK - model.dark_flicker_counts * np.log(np.maximum(chance, 1e-30))
    return np.asarray(counts, dtype=np.float32)
