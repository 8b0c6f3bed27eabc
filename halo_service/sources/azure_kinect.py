"""A live Azure Kinect, through pyk4a, the Python wrapper of its SDK.

Rule: pyk4a is imported only here, and only when a camera is opened; many machines lack it. Depth
NFOV unbinned with its infrared, colour 720p as the camera's own JPEG, 30 fps, only captures that
have both.

Tested without a camera: no camera connected, the calibration, and a capture of the SDK's playback
turned into a frame. Not tested: a camera that another program uses, one that is unplugged while
it runs, and the true delay between exposure and timestamp.
"""

from __future__ import annotations

import os
import time
from types import ModuleType
from typing import Any

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera
from halo_service.host_clock import CLOCK
from halo_service.sources import SourceLost
from halo_service.sources.clock import DeviceClock
from halo_service.values import BadFrame, Frame, SourceKind

_FPS = 30
_MOST_DELAY_US = 1_000_000
"""Longest time between a frame's arrival and its read; more means another clock."""
_OR_ELSE = "or choose another source: --source recording:FILE or --source sim"


def connected() -> int:
    """Count the connected Azure Kinects; 0 also without the SDK."""
    try:
        return int(_sdk().connected_device_count())
    except UserError:
        return 0


class AzureKinect:
    """A `Source`: the first connected Azure Kinect."""

    kind: SourceKind = "camera"

    def __init__(self) -> None:
        """Start the cameras; raises UserError if there is none or it cannot be started."""
        self._sdk = _sdk()
        if self._sdk.connected_device_count() == 0:
            raise UserError(f"no Azure Kinect is plugged in: plug one in, {_OR_ELSE}.")
        self._device = self._started()
        try:
            self.camera: Camera = k4a.from_json(
                self._device.calibration_raw.encode(),
                depth_mode="NFOV_UNBINNED",
                colour_resolution="720P",
                fps=_FPS,
            )
        except UserError:
            self._device.stop()
            raise
        self._clock = DeviceClock()
        self._open = True

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Wait for the next capture; raises SourceLost if the camera is gone."""
        try:
            capture = self._device.get_capture(timeout=round(timeout_s * 1000))
        except self._sdk.K4ATimeoutException:
            return None
        except self._sdk.K4AException as error:
            self.close()
            raise SourceLost(
                "the Azure Kinect went away: check its cable and its power."
            ) from error
        return outcome(capture, self._clock)

    def expose(self, exposure_ms: float | None) -> None:
        """Set the colour camera's exposure; the device uses the nearest time that it supports."""
        try:
            if exposure_ms is None:
                self._device.exposure_mode_auto = True
            else:
                self._device.exposure = round(exposure_ms * 1000)
        except self._sdk.K4AException as error:
            self.close()
            raise SourceLost(
                "the Azure Kinect went away: check its cable and its power."
            ) from error

    def close(self) -> None:
        """Stop the cameras. May be called twice."""
        if not self._open:
            return
        self._open = False
        try:
            self._device.stop()
        except self._sdk.K4AException:
            # An unplugged camera cannot be stopped and does not need it.
            self._device.is_running = False

    def _started(self) -> Any:
        sdk = self._sdk
        config = sdk.Config(
            color_format=sdk.ImageFormat.COLOR_MJPG,
            color_resolution=sdk.ColorResolution.RES_720P,
            depth_mode=sdk.DepthMode.NFOV_UNBINNED,
            camera_fps=sdk.FPS.FPS_30,
            synchronized_images_only=True,
        )
        # "Thread-safe" in pyk4a holds Python's lock while it waits for a frame, which blocks
        # every other thread. Only one thread uses the camera, so the lock is not needed.
        device = sdk.PyK4A(config, thread_safe=False)
        try:
            device.start()
        except sdk.K4AException as error:
            if device.opened:
                device.close()
            raise UserError(
                "an Azure Kinect is plugged in but cannot be started: close other programs that "
                "use it, plug it into a USB 3 port with its own power, on Linux install its udev "
                f"rules, {_OR_ELSE}."
            ) from error
        return device


def outcome(capture: Any, clock: DeviceClock) -> Frame | BadFrame:
    """Turn a pyk4a capture into a frame in Unix time, its JPEG untouched."""
    depth, ir, colour = capture.depth, capture.ir, capture.color
    if depth is None or ir is None:
        lacking = "depth" if depth is None else "IR"
        return BadFrame(CLOCK.unix_us(), f"no {lacking} in this capture")
    time_us = clock.unix_us(
        capture.depth_timestamp_usec, _arrived_us(capture.depth_system_timestamp_nsec)
    )
    jpeg = None if colour is None else np.asarray(colour, np.uint8).tobytes()
    return Frame(time_us, depth, ir, jpeg)


def _arrived_us(system_ns: int) -> int:
    """Unix time at which the host had a frame that the SDK stamped by `perf_counter`."""
    delay_us = (time.perf_counter_ns() - system_ns) // 1000
    return CLOCK.unix_us() - (delay_us if 0 <= delay_us <= _MOST_DELAY_US else 0)


def _sdk() -> ModuleType:
    # The SDK prints its messages on stdout, among our output; it reads this variable once.
    os.environ.setdefault("K4A_ENABLE_LOG_TO_STDOUT", "0")
    try:
        import pyk4a
    except (ImportError, OSError) as error:
        raise UserError(
            "the Azure Kinect's software (pyk4a) is not installed; it exists for Linux and "
            f"Windows on x86-64: use such a machine, {_OR_ELSE}."
        ) from error
    return pyk4a
