"""A live Femto Bolt or Femto Mega: a `Source`.

Rule: the device is configured in `_configure` alone. It gives depth, infrared and colour 720p as
its own JPEG, at the rate of the depth mode, and only captures that have all three.
"""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable
from typing import Any

from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera
from halo_service.sources import SourceLost
from halo_service.sources.camera_name import TITLES, CameraKind, CameraOptions
from halo_service.sources.clock import DeviceClock
from halo_service.sources.headless import DISPLAY_REMEDY, is_engine, without_display
from halo_service.sources.orbbec.calibration import camera_of
from halo_service.sources.orbbec.frames import outcome
from halo_service.sources.orbbec.sdk import Plugged, Sdk, load
from halo_service.values import BadFrame, Frame, SourceKind

log = logging.getLogger(__name__)

COLOUR = "720P"
_EXPOSURE_STEP_MS = 0.1
"""A Femto counts the exposure in steps of 100 us (OrbbecSDK-K4A-Wrapper, ob_k4a_impl.cpp)."""
_LOOK_S = 1.0
"""A camera that is silent for so long is looked for in the list of devices."""
_OR_ELSE = "or choose another source: --source recording:FILE or --source sim"


class Femto:
    """A `Source`: a connected Femto."""

    kind: SourceKind = "camera"

    def __init__(
        self,
        kind: CameraKind,
        options: CameraOptions = CameraOptions(),  # noqa: B008 - frozen
        sdk: Callable[[], Sdk] | None = None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """Start the camera with this serial number; without one the first of this kind.

        `sdk`: loads the SDK; None: the installed one. `now_s`: a monotonic clock.

        Raises UserError if there is none or it cannot be started.
        """
        self._title = TITLES[kind]
        self._sdk = (sdk or load)()
        self._ob = self._sdk.module
        self._now_s = now_s
        self._listed = not options.address
        device = self._device(kind, options)
        if kind == "femto-bolt" and without_display(sys.platform, os.environ):
            raise UserError(f"a Femto Bolt is plugged in but cannot be started: {DISPLAY_REMEDY}")
        try:
            self.serial = str(device.get_device_info().get_serial_number())
            self._pipeline, self.camera = self._started(device, options)
        except self._ob.OBError as error:
            raise self._cannot_start(str(error)) from error
        self._device_in_use = device
        self._clock = DeviceClock()
        self._received_s = now_s()
        self._timed = True
        self._open = True

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Wait for the next capture; raises SourceLost if the camera is gone."""
        try:
            frames = self._pipeline.wait_for_frames(max(round(timeout_s * 1000), 1))
        except self._ob.OBError as error:
            raise self._lost() from error
        if frames is None:
            if self._now_s() - self._received_s > _LOOK_S and not self._is_plugged():
                raise self._lost()
            return None
        self._received_s = self._now_s()
        self._check_time(frames)
        return outcome(self._ob, frames, self.camera.depth, self._clock)

    def expose(self, exposure_ms: float | None) -> None:
        """Set the colour camera's exposure; the device uses the nearest time that it supports."""
        try:
            self._expose(self._device_in_use, exposure_ms)
        except self._ob.OBError as error:
            raise self._lost() from error

    def temperature_c(self) -> float | None:
        """Return the temperature of the depth sensor, degrees Celsius; None: not reported."""
        try:
            found = float(self._device_in_use.get_temperature().ir_temperature)
        except self._ob.OBError:
            return None
        return found or None

    def close(self) -> None:
        """Stop the camera. May be called twice."""
        if not self._open:
            return
        self._open = False
        try:
            self._pipeline.stop()
        except self._ob.OBError as error:  # an unplugged camera cannot be stopped
            log.debug("camera: %s", error)

    def _device(self, kind: CameraKind, options: CameraOptions) -> Any:
        try:
            if options.address:
                return self._sdk.network_device(options.address)
            return self._sdk.device(self._choose(kind, options.serial))
        except self._ob.OBError as error:
            if options.address:
                raise UserError(
                    f"no {self._title} answers at {options.address} ({error}): check the address "
                    f"and the cable, {_OR_ELSE}"
                ) from error
            raise self._cannot_start(str(error)) from error

    def _choose(self, kind: CameraKind, serial: str) -> str:
        found = self._sdk.plugged()
        fitting = [each.serial for each in found if each.kind == kind]
        if serial in fitting or (fitting and not serial):
            return serial or fitting[0]
        raise UserError(_not_there(kind, serial, fitting, found))

    def _started(self, device: Any, options: CameraOptions) -> tuple[Any, Camera]:
        ob, sensors = self._ob, self._ob.OBSensorType
        self._configure(device, options)
        pipeline = ob.Pipeline(device)
        size, fps = k4a.DEPTH_MODES[options.mode].size, k4a.DEPTH_FPS[options.mode]
        depth = self._profile(pipeline, sensors.DEPTH_SENSOR, size, ob.OBFormat.Y16, fps)
        infrared = self._profile(pipeline, sensors.IR_SENSOR, size, ob.OBFormat.Y16, fps)
        size = k4a.COLOUR_RESOLUTIONS[COLOUR].size
        colour = self._profile(pipeline, sensors.COLOR_SENSOR, size, ob.OBFormat.MJPG, fps)
        config = ob.Config()
        for profile in (depth, infrared, colour):
            config.enable_stream(profile)
        config.set_frame_aggregate_output_mode(ob.OBFrameAggregateOutputMode.FULL_FRAME_REQUIRE)
        camera = camera_of(self.serial, depth, colour)
        pipeline.enable_frame_sync()
        pipeline.start(config)
        return pipeline, camera

    def _profile(
        self, pipeline: Any, sensor: Any, size: tuple[int, int], form: Any, fps: int
    ) -> Any:
        profiles, (width, height) = pipeline.get_stream_profile_list(sensor), size
        try:
            return profiles.get_video_stream_profile(width, height, form, fps)
        except self._ob.OBError as error:
            raise UserError(
                f"the {self._title} {self.serial} has no {sensor.name} of {width} x {height} at "
                f"{fps} fps: update its firmware, or choose another mode="
            ) from error

    def _configure(self, device: Any, options: CameraOptions) -> None:
        ids = self._ob.OBPropertyID
        self._expose(device, options.exposure_ms)
        if options.gain is not None:
            device.set_int_property(ids.OB_PROP_COLOR_GAIN_INT, options.gain)
        if options.power_line_hz is not None:
            modes = self._ob.OBPowerLineFreqMode
            wanted = modes.FREQUENCY_50HZ if options.power_line_hz == 50 else modes.FREQUENCY_60HZ
            device.set_int_property(ids.OB_PROP_COLOR_POWER_LINE_FREQUENCY_INT, int(wanted))
        self._synchronise(device, options)

    def _expose(self, device: Any, exposure_ms: float | None) -> None:
        ids = self._ob.OBPropertyID
        device.set_bool_property(ids.OB_PROP_COLOR_AUTO_EXPOSURE_BOOL, exposure_ms is None)
        if exposure_ms is not None:
            steps = max(round(exposure_ms / _EXPOSURE_STEP_MS), 1)
            device.set_int_property(ids.OB_PROP_COLOR_EXPOSURE_INT, steps)

    def _synchronise(self, device: Any, options: CameraOptions) -> None:
        """Set the role on the sync cable. The device remembers it, so it is written only if new."""
        modes = self._ob.OBMultiDeviceSyncMode
        mode = {
            "alone": modes.STANDALONE,
            "primary": modes.PRIMARY,
            "secondary": modes.SECONDARY,
        }[options.sync]
        config = device.get_multi_device_sync_config()
        wanted = (mode, options.sync_delay_us, options.sync_delay_us)
        if (config.mode, config.depth_delay_us, config.color_delay_us) != wanted:
            config.mode, config.depth_delay_us, config.color_delay_us = wanted
            device.set_multi_device_sync_config(config)

    def _check_time(self, frames: Any) -> None:
        """Say once that the device gives no time of its own."""
        depth = frames.get_depth_frame()
        if not self._timed or depth is None or depth.get_timestamp_us():
            return
        self._timed = False
        log.warning(
            "camera: the %s sends no time of its own, so frames have the time of their arrival, "
            "which varies more; on Windows, run the SDK's setup_env.py once as administrator",
            self._title,
        )

    def _is_plugged(self) -> bool:
        return not self._listed or any(each.serial == self.serial for each in self._sdk.plugged())

    def _lost(self) -> SourceLost:
        self.close()
        return SourceLost(f"the {self._title} went away: check its cable and its power.")

    def _cannot_start(self, reason: str) -> UserError:
        what = f"a {self._title} is plugged in but cannot be started ({reason})"
        if is_engine(reason) and without_display(sys.platform, os.environ):
            return UserError(f"{what}: {DISPLAY_REMEDY}")
        return UserError(
            f"{what}: close other programs that use it, plug it into a USB 3 port with its own "
            f"power, on Linux run 'halo doctor --fix' for its permissions, {_OR_ELSE}."
        )


def _not_there(kind: CameraKind, serial: str, fitting: list[str], found: list[Plugged]) -> str:
    title = TITLES[kind]
    if fitting:
        return (
            f"the {title} {serial} is not plugged in; here: {', '.join(fitting)}: choose one with "
            f"--source {kind},serial={fitting[0]}, or plug the other in"
        )
    others = [f"{each.name} {each.serial}" for each in found]
    plugged = f" (plugged in: {', '.join(others)})" if others else ""
    near = next((each.kind for each in found if each.kind), None)
    remedy = f"choose --source {near}" if near else f"plug one in, {_OR_ELSE}"
    return f"no {title} is plugged in{plugged}: {remedy}."
