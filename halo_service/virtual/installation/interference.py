"""What another camera's light does to depth, where both cameras light the same place.

It imitates the effect; it does not simulate it. When lasers are on is published. What their light
then does to depth is not: owners report "significantly more invalid pixels" without a figure
(Azure_Kinect_ROS_Driver #204), so the amounts below are chosen.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.virtual.camera import MODES
from halo_service.virtual.clock import Clock
from halo_service.virtual.exposure import PULSES
from halo_service.virtual.pools import Pool
from halo_service.virtual.room import Room
from halo_service.virtual.scene import View

Image = NDArray[np.float32]

PULSE_US = 125.0
"""For each depth image the laser is on nine times for 125 us, and off in between for as long as the
depth mode says (Azure Kinect DK, "Synchronize multiple devices")."""
NOISE_MM = 6.0
"""Deviation of depth where another camera lights all nine pulses as brightly; chosen."""
LOSS = 0.25
"""Share of such pixels that read 0; chosen."""
SOFT = 0.2
"""Width of the lit circle's edge, of its radius; chosen."""
_SPARE = 100


def common_light(apart_us: float, idle_us: float) -> float:
    """Share of one camera's pulses in which another's laser is on that starts so much later.

    `idle_us`: between two pulses, of both.
    """
    period = PULSE_US + idle_us
    pulses = round(apart_us / period)
    common_us = max(0.0, PULSE_US - abs(apart_us - pulses * period))
    return common_us / PULSE_US * max(0, PULSES - abs(pulses)) / PULSES


def shares(mine: Clock, others: Mapping[int, Clock], index: int) -> dict[int, float]:
    """How much of the light of my frame `index` each other camera shares; only those that do."""
    now_s = mine.exposed_s(index)
    found = {}
    for number, other in others.items():
        nearest = round((now_s - other.first_s) * other.fps)
        share = common_light(1e6 * (other.exposed_s(nearest) - now_s), mine.idle_us)
        if share > 0.0:
            found[number] = share
    return found


class Interference:
    """The noise that other cameras add to one camera's depth."""

    def __init__(self, room: Room, lens: Lens, view: View) -> None:
        self._light = {
            number: _light_of(room, number, lens, view)
            for number in room.installation.numbers
            if number != room.installation.camera
        }
        shape = lens.height, lens.width
        size = shape[0] + _SPARE, shape[1] + _SPARE
        rng = np.random.default_rng([*room.noise_seed, 6])
        self._white = Pool(rng.standard_normal(size, np.float32), shape)
        self._even = Pool(rng.random(size, np.float32), shape)

    def disturb(
        self, depth: NDArray[np.uint16], shared: Mapping[int, float], rng: np.random.Generator
    ) -> None:
        """Add noise, and take pixels away, in place. `shared`: see `shares`."""
        if not shared:
            return
        light = sum((self._light[number] * share for number, share in shared.items()), 0.0)
        strength = np.asarray(light, np.float32)
        noisy = depth + np.float32(NOISE_MM) * strength * self._white.draw(rng)
        lost = (depth == 0) | (self._even.draw(rng) < np.float32(LOSS) * strength)
        depth[:] = np.where(lost, 0, np.rint(np.maximum(noisy, 0.0))).astype(np.uint16)


def _light_of(room: Room, number: int, lens: Lens, view: View) -> Image:
    """(H, W) brightness of another camera's light on the table: 1 inside its lit circle.

    All cameras count as being at this one's height.
    """
    from_canvas = np.linalg.inv(room.place.canvas_from_surface)
    middle = np.append(room.place_of(number).middle_mm, (0.0, 1.0))
    x, y = (from_canvas @ middle)[:2]
    away = np.hypot(view.x_mm - np.float32(x), view.y_mm - np.float32(y))
    field = MODES[room.mode].field * lens.height / 2.0 / lens.fy
    radius = np.float32(field * room.camera_height_mm)
    return np.asarray(np.clip((radius - away) / (SOFT * radius), 0.0, 1.0), dtype=np.float32)
