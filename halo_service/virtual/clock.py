"""The device's clock and pace: when a frame is exposed, and what its timestamp says.

Rule: pure; host time is seconds from the first frame. In an installation all cameras share it, and
each begins a little later.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace

import numpy as np

from halo_service.geometry.k4a import DEPTH_FPS
from halo_service.virtual.camera import DEPTH_MODE, DEVICES, MODES
from halo_service.virtual.room import Room

START_US = 500_000
"""Timestamp of a Kinect's first frame: a device's clock does not start at 0."""
MINUTE_S = 60.0
UPTIME_S = 60.0, 3600.0
UNIX_S = 1.6e9, 1.75e9
"""A Bolt's first timestamp: minutes, or years as Unix time (OrbbecSDK-K4A-Wrapper #94)."""


@dataclass(frozen=True, slots=True)
class Clock:
    """One start of one device."""

    fps: float
    """Frames a second of host time."""
    start_us: int = START_US
    """Timestamp at host time 0."""
    drift_ppm: float = 0.0
    """How much faster it runs than the host's."""
    slow_s: float = 0.0
    """For so long in each minute only every other frame arrives."""
    slow_from_s: float = 0.0
    """Where in a minute that begins."""
    first_s: float = 0.0
    """Host time of the first frame."""
    idle_us: float = MODES[DEPTH_MODE].idle_us
    """Between two pulses of its laser."""

    def exposed_s(self, index: int) -> float:
        """Host time at which a frame is due."""
        return self.first_s + index / self.fps

    def device_us(self, host_s: float) -> int:
        """The timestamp of a moment of host time."""
        return self.start_us + round(host_s * (1e6 + self.drift_ppm))

    def host_s(self, device_us: int) -> float:
        """The moment of a timestamp."""
        return (device_us - self.start_us) / (1e6 + self.drift_ppm)

    def frame_s(self, host_s: float) -> float:
        """Seconds since host time 0, by the timestamps."""
        return host_s * (1.0 + self.drift_ppm / 1e6)

    def skips(self, index: int) -> bool:
        """Whether a frame is lost because the rate has dropped; never the first."""
        if index % 2 == 0:
            return False
        return (self.exposed_s(index) - self.slow_from_s) % MINUTE_S < self.slow_s


APART_US, APART_PPM = 5e6, 30.0
"""Between the clocks of an installation: at most so long from one start to another, and so much
drift to either side of the model's; chosen."""


def clocks_of(room: Room, scenario: str) -> dict[int, Clock]:
    """The clocks of all cameras of the room's installation, by their numbers."""
    first = _one_clock(room, scenario)
    if room.installation.alone:
        return {1: first}
    return {number: _joined(first, room, number) for number in room.installation.numbers}


def clock_of(room: Room, scenario: str) -> Clock:
    """The clock of the room's device in one scenario: each start draws another."""
    return clocks_of(room, scenario)[room.installation.camera]


def _joined(first: Clock, room: Room, number: int) -> Clock:
    """One camera's clock of several: wired cameras share the pace, others have their own."""
    rng = np.random.default_rng([room.seed, zlib.crc32(b"joined"), number])
    start_us = first.start_us + round(rng.uniform(0.0, APART_US) / 1e3) * 1000
    ppm = float(rng.uniform(-APART_PPM, APART_PPM))
    fps, first_s = first.fps, 1e-6 * (number - 1) * room.installation.delay_us
    if room.installation.sync == "none":
        fps *= 1.0 + 1e-6 * ppm
        first_s = float(rng.uniform(0.0, 1.0 / fps))
    return replace(
        first,
        fps=fps,
        start_us=start_us,
        drift_ppm=first.drift_ppm + ppm,
        slow_from_s=float(rng.uniform(0.0, MINUTE_S)),
        first_s=first_s,
    )


def _one_clock(room: Room, scenario: str) -> Clock:
    rng = np.random.default_rng([room.seed, zlib.crc32(b"clock"), zlib.crc32(scenario.encode())])
    of_narrow = DEPTH_FPS[room.mode] / DEPTH_FPS[DEPTH_MODE]
    fps = float(rng.uniform(*DEVICES[room.device].fps)) * of_narrow
    start_s = rng.uniform(*(UNIX_S if rng.random() < 0.5 else UPTIME_S))
    return Clock(
        fps,
        # Whole milliseconds, as recordings have them.
        START_US if room.device == "kinect" else round(start_s * 1e3) * 1000,
        room.sensor.clock_drift_ppm,
        room.sensor.slow_s_per_minute,
        float(rng.uniform(0.0, MINUTE_S)),
        idle_us=MODES[room.mode].idle_us,
    )
