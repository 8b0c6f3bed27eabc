"""A fake device behind Orbbec's real SDK.

What is real: frames, frame sets, enumerations, calibration values and errors of the installed
`pyorbbecsdk`. What is fake: device, list of devices, stream profiles and pipeline, because no
camera is here. The pipeline shows recorded frames. A test compares each fake name with the real
class.
"""

import importlib.util
import os
import time

import numpy as np
import pytest

from halo_service.geometry.camera import Camera, Lens
from halo_service.sources.orbbec.sdk import Sdk
from halo_service.values import Frame

BOLT, GEMINI = 0x066B, 0x0800


def real():
    """The installed module, loaded as the service loads it."""
    if importlib.util.find_spec("pyorbbecsdk") is None:
        missing = "the SDK of Orbbec is not installed (--extra orbbec)"
        pytest.fail(missing) if os.environ.get("HALO_CI") else pytest.skip(missing)
    from halo_service.sources.orbbec import sdk

    return sdk.load().module


class FakeDeviceList:
    def __init__(self, bench):
        self.bench = bench

    def get_count(self):
        return len(self.bench.devices)

    def get_device_name_by_index(self, index):
        return self.bench.devices[index].name

    def get_device_pid_by_index(self, index):
        return self.bench.devices[index].pid

    def get_device_serial_number_by_index(self, index):
        return self.bench.devices[index].serial

    def get_device_connection_type_by_index(self, index):
        return "USB3.1"

    def get_device_by_serial_number(self, serial):
        for device in self.bench.devices:
            if device.serial == serial:
                return device
        raise self.bench.ob.OBError(f"Device not found by serial number: {serial}")


class FakeContext:
    def __init__(self, bench):
        self.bench = bench

    def query_devices(self):
        return FakeDeviceList(self.bench)

    def create_net_device(self, address, port):
        raise self.bench.ob.OBError(f"no answer from {address}:{port}")


class FakeDeviceInfo:
    def __init__(self, device):
        self.device = device

    def get_serial_number(self):
        return self.device.serial


class FakeDevice:
    def __init__(self, bench, serial, pid=BOLT, name="Orbbec FemtoBolt"):
        self.bench, self.serial, self.pid, self.name = bench, serial, pid, name
        self.written = {}
        self.sync = bench.ob.OBMultiDeviceSyncConfig()
        self.sync.mode = bench.ob.OBMultiDeviceSyncMode.STANDALONE
        self.sync.depth_delay_us = self.sync.color_delay_us = 0
        self.sync_writes = 0
        self.celsius = 41.5

    def get_device_info(self):
        return FakeDeviceInfo(self)

    def set_int_property(self, name, value):
        assert isinstance(value, int)
        self.written[name.name] = value

    def set_bool_property(self, name, value):
        assert isinstance(value, bool)
        self.written[name.name] = value

    def get_multi_device_sync_config(self):
        return self.sync

    def set_multi_device_sync_config(self, config):
        self.sync, self.sync_writes = config, self.sync_writes + 1

    def get_temperature(self):
        found = self.bench.ob.OBDeviceTemperature()
        found.ir_temperature = self.celsius
        return found


class FakePlaybackDevice(FakeDevice):
    """A `.bag` with the bench's frames."""

    def get_playback_status(self):
        states = self.bench.ob.OBPlaybackStatus
        ended = self.bench.pipelines[-1].shown >= len(self.bench.frames)
        return states.STOPPED if ended else states.PLAYING


class FakeVideoStreamProfile:
    def __init__(self, bench, lens: Lens, extrinsic=None):
        self.bench, self.lens, self.extrinsic = bench, lens, extrinsic
        self.model = bench.ob.OBCameraDistortionModel.BROWN_CONRADY_K6

    def get_width(self):
        return self.lens.width

    def get_height(self):
        return self.lens.height

    def get_fps(self):
        return self.bench.fps

    def get_intrinsic(self):
        found = self.bench.ob.OBCameraIntrinsic()
        for name in ("fx", "fy", "cx", "cy", "width", "height"):
            setattr(found, name, getattr(self.lens, name))
        return found

    def get_distortion(self):
        found = self.bench.ob.OBCameraDistortion()
        names = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
        for name, value in zip(names, self.lens.distortion, strict=True):
            setattr(found, name, value)
        found.model = self.model
        return found

    def get_extrinsic_to(self, other):
        return self.extrinsic


class FakeStreamProfileList:
    def __init__(self, bench, profile):
        self.bench, self.profile = bench, profile

    def get_video_stream_profile(self, width, height, form, fps):
        profile = self.profile
        if (width, height, fps) != (profile.get_width(), profile.get_height(), profile.get_fps()):
            raise self.bench.ob.OBError("no matched video stream profile")
        return self.profile

    def get_default_video_stream_profile(self):
        return self.profile


class FakeConfig:
    def enable_stream(self, profile):
        assert isinstance(profile, FakeVideoStreamProfile)

    def set_frame_aggregate_output_mode(self, mode):
        pass


class FakePipeline:
    def __init__(self, bench, device):
        self.bench, self.device, self.shown = bench, device, 0
        self.stopped = 0

    def get_stream_profile_list(self, sensor):
        return FakeStreamProfileList(self.bench, self.bench.profiles[sensor.name])

    def enable_frame_sync(self):
        pass

    def start(self, config):
        if self.bench.start_fails:
            raise self.bench.ob.OBError(self.bench.start_fails)

    def wait_for_frames(self, timeout_ms):
        assert isinstance(timeout_ms, int)
        assert timeout_ms > 0
        if isinstance(self.device, FakePlaybackDevice):
            if self.shown >= len(self.bench.frames):
                assert timeout_ms <= 1000, "the SDK would wait for so long"
                return None
        elif self.device not in self.bench.devices:
            return None  # the SDK waits in vain for a camera that was unplugged
        self.shown += 1
        return self.bench.frame_set(self.shown)

    def stop(self):
        self.stopped += 1
        gone = self.device not in self.bench.devices
        if gone and not isinstance(self.device, FakePlaybackDevice):
            raise self.bench.ob.OBError("camera disconnected")


class OrbbecBench:
    """Cameras on a table, and their SDK."""

    def __init__(self, camera: Camera, frames: list[Frame], serials=("A", "B")):
        self.ob = real()
        self.frames, self.spoilt, self.fps = frames, {}, camera.fps
        self.devices = [FakeDevice(self, serial) for serial in serials]
        self.start_fails = ""
        self.zero_time = False
        self.pipelines = []
        pose = self.ob.OBExtrinsic()
        pose.rot = np.ascontiguousarray(camera.colour_from_depth[:3, :3], np.float32)
        pose.transform = np.ascontiguousarray(camera.colour_from_depth[:3, 3], np.float32)
        depth = FakeVideoStreamProfile(self, camera.depth, pose)
        self.profiles = {
            "DEPTH_SENSOR": depth,
            "IR_SENSOR": depth,
            "COLOR_SENSOR": FakeVideoStreamProfile(self, camera.colour),
        }

    def sdk(self) -> Sdk:
        return Sdk(_Module(self), FakeContext(self))

    def frame_set(self, number):
        """Recorded frame `number` as the SDK's own frame set."""
        frame = self.frames[number % len(self.frames)]
        lacks = self.spoilt.get(number)
        found = self.ob.Frame.create_frame_set()
        if lacks != "depth":
            found.push_frame(self._grey("DEPTH_FRAME", frame.depth, number, lacks == "torn depth"))
        if lacks != "IR":
            found.push_frame(self._grey("IR_FRAME", frame.ir, number, lacks == "torn IR"))
        colour = self.ob.Frame.create_frame(
            self.ob.OBFrameType.COLOR_FRAME, self.ob.OBFormat.MJPG, len(frame.colour)
        )
        colour.update_data(frame.colour)
        found.push_frame(colour)
        return found

    def _grey(self, kind, image, number, torn):
        ob = self.ob
        height, width = image.shape
        made = ob.Frame.create_video_frame(
            getattr(ob.OBFrameType, kind), ob.OBFormat.Y16, width, height // 2 if torn else height
        )
        made.update_data((image[: height // 2] if torn else image).tobytes())
        if not self.zero_time:
            ob.Frame.set_frame_device_timestamp_us(made, 5_000_000 + number * 1_000_000 // self.fps)
        made.set_system_timestamp_us(time.time_ns() // 1000)
        return made


class _Module:
    """The real module, but for what needs a device."""

    Config = FakeConfig

    def __init__(self, bench):
        self._bench = bench

    def __getattr__(self, name):
        return getattr(self._bench.ob, name)

    def PlaybackDevice(self, file):  # noqa: N802 - the SDK's name
        return FakePlaybackDevice(self._bench, "B")

    def Pipeline(self, device):  # noqa: N802 - the SDK's name
        self._bench.pipelines.append(FakePipeline(self._bench, device))
        return self._bench.pipelines[-1]


FAKES = {
    "DeviceList": FakeDeviceList,
    "Context": FakeContext,
    "DeviceInfo": FakeDeviceInfo,
    "Device": FakeDevice,
    "VideoStreamProfile": FakeVideoStreamProfile,
    "StreamProfileList": FakeStreamProfileList,
    "Config": FakeConfig,
    "Pipeline": FakePipeline,
    "PlaybackDevice": FakePlaybackDevice,
}
"""Each fake class, by the name of the real one."""
