"""A fault injector: a camera and a hand tracker over a drawn table, with faults that are switched.

The finger taps twice a second. A whole service runs on it, as `benchmarks/soak.py` does: nothing
but camera and hands is replaced, so each fault goes through the real parts.
"""

from __future__ import annotations

import mmap
import threading
import time
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera
from halo_service.host_clock import CLOCK
from halo_service.profile import Profile
from halo_service.sources import SourceLost
from halo_service.values import BadFrame, Frame, SourceKind, Tracked
from tests.drawn import DEPTHS_MM, MIDDLE, VIEWS

FPS = 30
CYCLE_S = 0.5
"""From tap to tap."""
MEGABYTE = bytes(10**6)
LEAK_MB = 10
"""Of a tracker that leaks, for each frame."""
STEPS = 15
"""Frames of a tap."""
HEIGHTS_MM = (30.0, 22.0, 14.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 7.0, 14.0, 22.0, 30.0, 30.0)
TABLE = VIEWS["350 mm"]

Fault = Literal[
    "drops", "stalls", "unplugged", "another device", "black", "no depth", "time ahead",
    "time back", "tilted", "tracker dies", "tracker hangs", "tracker leaks", "clock stepped",
    "hands away",
]  # fmt: skip


@dataclass
class Faults:
    """Which faults are on now. One per process; switched from any thread."""

    on: set[Fault] = field(default_factory=set)
    shift_us: int = 0
    """What the camera's time is off by."""
    hang: threading.Event = field(default_factory=threading.Event)
    """Set: a tracker that hangs goes on."""

    def begin(self, fault: Fault) -> None:
        """Switch a fault on."""
        if fault == "tracker hangs":
            self.hang.clear()
        elif fault == "clock stepped":
            CLOCK._unix_ns = lambda: time.time_ns() - 30_000_000_000
        elif fault in ("time ahead", "time back"):
            self.shift_us += 10_000_000 if fault == "time ahead" else -5_000_000
        self.on.add(fault)

    def end(self, fault: Fault) -> None:
        """Switch it off."""
        self.on.discard(fault)
        if fault == "tracker hangs":
            self.hang.set()
        elif fault == "clock stepped":
            CLOCK._unix_ns = time.time_ns


FAULTS = Faults()


def profile() -> Profile:
    """Return the profile of the drawn table, which a service can save and load."""
    return replace(TABLE.profile, name="soak")


class FaultyCamera:
    """A `Source` at 30 frames a second."""

    kind: SourceKind = "camera"
    _pictures: ClassVar[list[Frame]] = []

    def __init__(self, faults: Faults = FAULTS) -> None:
        """Raises `UserError` while the camera is unplugged."""
        if "unplugged" in faults.on:
            raise UserError("no camera is plugged in")
        self._faults = faults
        other = "another device" in faults.on
        self.camera: Camera = replace(TABLE.camera, serial="OTHER" if other else "DRAWN")
        self._due_s = time.monotonic()
        self._random = np.random.default_rng(1)
        self._empty = TABLE.empty
        if not self._pictures:
            deep = float(DEPTHS_MM["touch"])
            drawn = [TABLE.frame(MIDDLE, deep if h == 0.0 else 0.0, h) for h in HEIGHTS_MM]
            self._pictures.extend(drawn)

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Return the next frame, or what the fault makes of it."""
        on = self._faults.on
        if on & {"unplugged", "another device"} and self.camera.serial == "DRAWN":
            raise SourceLost("the camera went away")
        if "stalls" in on:
            time.sleep(timeout_s)
            return None
        self._due_s = max(self._due_s + 1.0 / FPS, time.monotonic() - 0.1)
        time.sleep(max(self._due_s - time.monotonic(), 0.0))
        if "drops" in on and self._random.random() < 0.6:
            return None
        time_us = CLOCK.unix_us() + self._faults.shift_us
        if "no depth" in on:
            return BadFrame(time_us, "no depth in this capture")
        picture = self._pictures[int(time.monotonic() / CYCLE_S * STEPS) % STEPS]
        if "hands away" in on:
            picture = self._empty
        depth = picture.depth
        if "black" in on:
            depth = np.zeros_like(depth)
        elif "tilted" in on:
            columns = np.arange(depth.shape[1]) - TABLE.lens.cx
            slope_mm = np.tan(np.radians(3.0)) * TABLE.distance_mm * columns / TABLE.lens.fx
            depth = np.rint(depth + slope_mm).astype(np.uint16)
        return Frame(time_us, depth, picture.ir)

    def close(self) -> None:
        """Nothing to close."""


class FaultyTracker:
    """A hand tracker that knows where the finger is."""

    def __init__(self, faults: Faults = FAULTS) -> None:
        self._faults = faults
        self._leaked: list[mmap.mmap] = []

    looks = 0

    def detect(self, frame: Frame) -> Tracked:
        """Return the hand, or fail as the fault asks."""
        if "tracker dies" in self._faults.on:
            raise RuntimeError("the model is broken")
        if "tracker hangs" in self._faults.on:
            self._faults.hang.wait()
        if "tracker leaks" in self._faults.on:
            self._leak()
        if "hands away" in self._faults.on:
            return Tracked(frame.time_us, ())
        return TABLE.hands(MIDDLE, frame.time_us)

    def close(self) -> None:
        """Free what leaked."""
        for each in self._leaked:
            each.close()

    def _leak(self) -> None:
        self._leaked.append(mmap.mmap(-1, LEAK_MB * 10**6))
        for _ in range(LEAK_MB):  # it takes memory once it is written, and nothing beyond it
            self._leaked[-1].write(MEGABYTE)
