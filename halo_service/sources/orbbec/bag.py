"""A `.bag` recording of OrbbecViewer or Orbbec's SDK, through the SDK's own playback: a `Source`.

The SDK plays it at the pace at which it was recorded. Never run on a real file: no public one was
found, and only a device can record one. `halo record --source recording:X.bag X.mkv` writes it in
our form.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from halo_service.errors import UserError
from halo_service.host_clock import CLOCK
from halo_service.sources import EndOfSource
from halo_service.sources.clock import DeviceClock
from halo_service.sources.orbbec.calibration import camera_of
from halo_service.sources.orbbec.frames import outcome
from halo_service.sources.orbbec.sdk import Sdk, load
from halo_service.values import BadFrame, Frame, SourceKind

_LONGEST_WAIT_S = 1.0


class Bag:
    """A `Source`: a recording in Orbbec's form. Its times are those of the device."""

    kind: SourceKind = "recording"

    def __init__(self, path: Path, *, realtime: bool, sdk: Callable[[], Sdk] = load) -> None:
        """`realtime`: times are Unix time, as of a live camera; else those of the file.

        Raises UserError if the SDK is not installed or the file cannot be played.
        """
        if not path.is_file():
            raise UserError(f"{path} does not exist; check the recording's path.")
        self._path = path
        self._ob = sdk().module
        try:
            self._playback = self._ob.PlaybackDevice(str(path))
            self._pipeline = self._ob.Pipeline(self._playback)
            self.camera = self._started()
        except (self._ob.OBError, RuntimeError) as error:
            raise UserError(
                f"{path} cannot be played by the SDK of Orbbec ({error}): record it again with "
                "depth, IR and colour (MJPG) switched on"
            ) from error
        self._clock = DeviceClock() if realtime else None
        self._open = True

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Return the next capture; None: nothing came in that time. Raises EndOfSource."""
        try:
            # At the end nothing comes any more, so a reader that waits for an hour must not.
            wait_ms = round(min(timeout_s, _LONGEST_WAIT_S) * 1000)
            frames = self._pipeline.wait_for_frames(max(wait_ms, 1))
        except self._ob.OBError as error:
            raise UserError(f"{self._path} cannot be read further ({error}).") from error
        if frames is None:
            if self._playback.get_playback_status() == self._ob.OBPlaybackStatus.STOPPED:
                raise EndOfSource
            return None
        if self._clock is not None:
            return outcome(self._ob, frames, self.camera.depth, self._clock)
        return outcome(self._ob, frames, self.camera.depth, _FileClock())

    def close(self) -> None:
        """Stop the playback. May be called twice."""
        if self._open:
            self._open = False
            self._pipeline.stop()

    def _started(self) -> Any:
        sensors = self._ob.OBSensorType
        depth, infrared, colour = (
            self._recorded(sensor)
            for sensor in (sensors.DEPTH_SENSOR, sensors.IR_SENSOR, sensors.COLOR_SENSOR)
        )
        config = self._ob.Config()
        for profile in (depth, infrared, colour):
            config.enable_stream(profile)
        serial = str(self._playback.get_device_info().get_serial_number())
        camera = camera_of(serial, depth, colour)
        self._pipeline.start(config)
        return camera

    def _recorded(self, sensor: Any) -> Any:
        """Return the profile that a stream was recorded in."""
        return self._pipeline.get_stream_profile_list(sensor).get_default_video_stream_profile()


class _FileClock(DeviceClock):
    """Leaves the device's time as it is."""

    def unix_us(self, device_us: int, arrived_us: int) -> int:
        """Return the device's own time; without one, the time of the read."""
        del arrived_us
        return device_us or CLOCK.unix_us()
