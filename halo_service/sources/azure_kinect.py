"""A live Azure Kinect, through pyk4a, the Python wrapper of its SDK.

Rule: pyk4a is imported only here, and only when a camera is looked for; many machines lack it.
Depth with its infrared and colour 720p as the camera's own JPEG, at the depth mode's rate; only
captures that have both.

Tested without a camera: no camera connected, the calibration, and a capture of the SDK's playback
turned into a frame. Tested with a fake device: options, unplug, a wrong serial number. Not tested:
the true delay between exposure and timestamp.
"""

from __future__ import annotations

import atexit
import os
import sys
import tempfile
import time
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera
from halo_service.host_clock import CLOCK
from halo_service.sources import SourceLost
from halo_service.sources.camera_name import CameraOptions
from halo_service.sources.clock import DeviceClock
from halo_service.sources.headless import DISPLAY_REMEDY, is_engine, without_display
from halo_service.values import BadFrame, Frame, SourceKind

_POWER_LINE = {50: 1, 60: 2}
"""The SDK's numbers for the frequency of the power line."""
_MOST_DELAY_US = 1_000_000
"""Longest time between a frame's arrival and its read; more means another clock."""
_LOG = Path(tempfile.gettempdir()) / f"halo-k4a-{os.getpid()}.log"
"""What the SDK logs while this process runs; its name must end in `.log`."""
_OR_ELSE = "or choose another source: --source recording:FILE or --source sim"


def connected() -> int:
    """Count the connected Azure Kinects; 0 also without the SDK."""
    try:
        return int(_sdk().connected_device_count())
    except UserError:
        return 0


class AzureKinect:
    """A `Source`: a connected Azure Kinect."""

    kind: SourceKind = "camera"

    def __init__(self, options: CameraOptions = CameraOptions()) -> None:  # noqa: B008 - frozen
        """Start the camera with this serial number; without one the first that can be opened.

        Raises UserError if there is none or it cannot be started.
        """
        self._sdk = _sdk()
        if self._sdk.connected_device_count() == 0:
            raise UserError(f"no Azure Kinect is plugged in: plug one in, {_OR_ELSE}.")
        self._options = options
        self._device = self._started(options.serial)
        try:
            self.camera: Camera = k4a.from_json(
                self._device.calibration_raw.encode(),
                depth_mode=options.mode,
                colour_resolution="720P",
                fps=k4a.DEPTH_FPS[options.mode],
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

    def _started(self, serial: str) -> Any:
        sdk = self._sdk
        said = _LOG.stat().st_size if _LOG.exists() else 0
        device = self._opened(serial)
        try:
            if device is not None:
                device.start()
                self._configure(device)
                return device
        except sdk.K4AException as error:
            device.close()
            raise _cannot_start(_reason(said)) from error
        raise _cannot_start(_reason(said))

    def _configure(self, device: Any) -> None:
        options = self._options
        if options.exposure_ms is not None:
            device.exposure = round(options.exposure_ms * 1000)
        if options.gain is not None:
            device.gain = options.gain
        if options.power_line_hz is not None:
            device.powerline_frequency = _POWER_LINE[options.power_line_hz]

    def _config(self) -> Any:
        sdk = self._sdk
        mode = self._options.mode
        role = {"alone": "STANDALONE", "primary": "MASTER", "secondary": "SUBORDINATE"}
        return sdk.Config(
            color_format=sdk.ImageFormat.COLOR_MJPG,
            color_resolution=sdk.ColorResolution.RES_720P,
            depth_mode=getattr(sdk.DepthMode, mode),
            camera_fps=getattr(sdk.FPS, f"FPS_{k4a.DEPTH_FPS[mode]}"),
            synchronized_images_only=True,
            wired_sync_mode=getattr(sdk.WiredSyncMode, role[self._options.sync]),
            subordinate_delay_off_master_usec=self._options.sync_delay_us,
        )

    def _opened(self, serial: str) -> Any:
        """Open the device with this serial number; None if no device can be opened."""
        sdk = self._sdk
        config = self._config()
        # "Thread-safe" in pyk4a holds Python's lock while it waits for a frame, which blocks
        # every other thread. Only one thread uses the camera, so the lock is not needed.
        others = []
        for number in range(sdk.connected_device_count()):
            device = sdk.PyK4A(config, device_id=number, thread_safe=False)
            try:
                device.open()
            except sdk.K4AException:
                continue  # another program uses it
            if serial in ("", device.serial):
                return device
            others.append(device.serial)
            device.close()
        if others:
            raise UserError(
                f"the Azure Kinect {serial} is not plugged in, or another program uses it; free "
                f"here: {', '.join(others)}: choose one with --source "
                f"azure-kinect,serial={others[0]}, or plug the other in"
            )
        return None


def _cannot_start(reason: str) -> UserError:
    """Return the error for a camera that does not start. `reason`: the SDK's own, or empty."""
    what = "an Azure Kinect is plugged in but cannot be started"
    if is_engine(reason) and without_display(sys.platform, os.environ):
        return UserError(f"{what} ({reason}): {DISPLAY_REMEDY}")
    shown = f" ({reason})" if reason else ""
    return UserError(
        f"{what}{shown}: close other programs that use it, plug it into a USB 3 port with its own "
        f"power, on Linux run 'halo doctor --fix' for its permissions, {_OR_ELSE}."
    )


def _reason(said: int) -> str:
    """Return what the SDK logged since its log had this many bytes, in one line."""
    try:
        lines = _LOG.read_bytes()[said:].decode(errors="replace").splitlines()
    except OSError:
        return ""
    for level in ("[critical]", "[error]"):
        for line in lines:
            if level in line and "returned failure in" not in line:
                return line.rpartition("): ")[2].partition("(). ")[2] or line.rpartition("): ")[2]
    return ""


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
    # The SDK prints its messages on stdout, among our output; it reads these variables once. Its
    # functions fail without a reason, which is only in its log.
    os.environ.setdefault("K4A_ENABLE_LOG_TO_STDOUT", "0")
    os.environ.setdefault("K4A_ENABLE_LOG_TO_A_FILE", str(_LOG))
    atexit.register(_LOG.unlink, missing_ok=True)
    try:
        import pyk4a
    except (ImportError, OSError) as error:
        raise UserError(
            "the Azure Kinect's software (pyk4a) is not installed; it exists for Linux and "
            f"Windows on x86-64: use such a machine, {_OR_ELSE}."
        ) from error
    return pyk4a
