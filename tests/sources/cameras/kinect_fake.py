"""A fake pyk4a with cameras that are not there; a test compares its names with the real module."""

import time
from dataclasses import replace
from types import SimpleNamespace

from halo_service.geometry import k4a


class FakePyK4A:
    """One device. `busy`: another program has it; `failing`: it does not start."""

    def __init__(self, bench, serial):
        self.bench, self.serial, self.shown = bench, serial, 0
        self.is_running = False
        self.exposure = self.gain = self.powerline_frequency = None
        self.exposure_mode_auto = True

    def open(self):
        if self.serial in self.bench.busy:
            raise self.bench.K4AException

    def start(self):
        if self.serial in self.bench.failing:
            raise self.bench.K4AException

    def stop(self):
        if self.serial not in self.bench.serials:
            raise self.bench.K4AException

    def close(self):
        self.bench.closed.append(self.serial)

    def get_capture(self, timeout):
        assert isinstance(timeout, int)
        if self.serial not in self.bench.serials:
            raise self.bench.K4AException
        self.shown += 1
        return self.bench.capture(self.shown)

    @property
    def calibration_raw(self):
        return k4a.to_json(replace(self.bench.camera, serial=self.serial)).decode()


class KinectBench:
    """The module with some cameras."""

    class K4AException(Exception):  # noqa: N818 - the SDK's name
        pass

    class K4ATimeoutException(K4AException):
        pass

    ImageFormat = SimpleNamespace(COLOR_MJPG=0)
    ColorResolution = SimpleNamespace(RES_720P=1)
    DepthMode = SimpleNamespace(
        NFOV_2X2BINNED=1, NFOV_UNBINNED=2, WFOV_2X2BINNED=3, WFOV_UNBINNED=4
    )
    FPS = SimpleNamespace(FPS_15=1, FPS_30=2)
    WiredSyncMode = SimpleNamespace(STANDALONE=0, MASTER=1, SUBORDINATE=2)

    def __init__(self, camera, frames=(), serials=("A", "B"), busy=(), failing=()):
        self.camera, self.frames = camera, frames
        self.serials, self.busy, self.failing = list(serials), busy, failing
        self.closed, self.spoilt, self.configs, self.devices = [], {}, [], []

    def connected_device_count(self):
        return len(self.serials)

    def Config(self, **given):  # noqa: N802 - the SDK's name
        self.configs.append(given)
        return given

    def PyK4A(self, config, device_id, thread_safe):  # noqa: N802 - the SDK's name
        self.devices.append(FakePyK4A(self, self.serials[device_id]))
        return self.devices[-1]

    def capture(self, number):
        """Recorded frame `number` as a capture."""
        frame = self.frames[number % len(self.frames)]
        lacks = self.spoilt.get(number)
        return SimpleNamespace(
            depth=None if lacks == "depth" else frame.depth.copy(),
            ir=None if lacks == "IR" else frame.ir.copy(),
            color=memoryview(frame.colour),
            depth_timestamp_usec=5_000_000 + number * 1_000_000 // self.camera.fps,
            depth_system_timestamp_nsec=time.perf_counter_ns(),
        )
