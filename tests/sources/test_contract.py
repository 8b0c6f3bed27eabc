"""What every source does, whatever its device: one contract, and every source passes it.

Devices are fakes behind their SDKs, with recorded frames (see `cameras/`); recording and virtual
camera are the real ones.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.sources import EndOfSource, Source, SourceLost, azure_kinect
from halo_service.sources.azure_kinect import AzureKinect
from halo_service.sources.camera_name import CameraOptions
from halo_service.sources.orbbec.bag import Bag
from halo_service.sources.orbbec.femto import Femto
from halo_service.sources.recording import Recording
from halo_service.sources.switched import SwitchedSource
from halo_service.values import BadFrame, Frame
from halo_service.virtual.live import VirtualKinect
from halo_service.virtual.sim_url import parse_sim_url
from tests.sources.cameras.kinect_fake import KinectBench
from tests.sources.cameras.orbbec_fake import OrbbecBench

SMALL, WIDE = CameraOptions(mode="NFOV_2X2BINNED"), CameraOptions(mode="WFOV_UNBINNED")
RATES = {SMALL: 30, WIDE: 15}
SOURCES = ("azure-kinect", "femto-bolt", "bag", "recording", "switched", "sim")
DEVICES = ("azure-kinect", "femto-bolt")


@dataclass
class Setup:
    """A source to test, and what can be done to its device."""

    open: Callable[[CameraOptions], Source]
    unplug: Callable[[], None]
    plug: Callable[[], None]
    spoil: Callable[[int, str], None]
    """Take an image out of the capture with this number."""


def no_device(*_: object) -> None:
    raise AssertionError("this source has no device")


@pytest.fixture
def options() -> CameraOptions:
    """The mode of the device, for tests that do not say another."""
    return SMALL


@pytest.fixture
def setup(request, monkeypatch, options) -> Setup:
    monkeypatch.setenv("DISPLAY", ":0")
    camera, frames, recording = (
        request.getfixturevalue(f"{'small' if options == SMALL else 'wide'}_{what}")
        for what in ("camera", "frames", "recording")
    )
    if request.param == "recording":
        return Setup(lambda _: Recording(recording, realtime=False, loop=False), *[no_device] * 3)
    if request.param == "switched":
        return Setup(
            lambda _: SwitchedSource(Recording(recording, realtime=False, loop=False)),
            *[no_device] * 3,
        )
    if request.param == "sim":
        fast = f"sim:demo,mode={options.mode},sensor=kind"
        return Setup(lambda _: VirtualKinect(parse_sim_url(fast)), *[no_device] * 3)
    if request.param == "bag":
        playback = OrbbecBench(camera, frames)
        return Setup(lambda _: Bag(recording, realtime=False, sdk=playback.sdk), *[no_device] * 3)
    if request.param == "azure-kinect":
        kinects = KinectBench(camera, frames)
        monkeypatch.setattr(azure_kinect, "_sdk", lambda: kinects)
        return Setup(
            AzureKinect,
            lambda: kinects.serials.remove("A"),
            lambda: kinects.serials.insert(0, "A"),
            kinects.spoilt.__setitem__,
        )
    bench = OrbbecBench(camera, frames)
    removed = bench.devices[0]
    now_s = iter(range(10_000))
    return Setup(
        lambda options: Femto("femto-bolt", options, bench.sdk, lambda: float(next(now_s))),
        lambda: bench.devices.remove(removed),
        lambda: bench.devices.insert(0, removed),
        bench.spoilt.__setitem__,
    )


def every(*names: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("setup", names, indirect=True)


def captures(source: Source, count: int) -> list[Frame | BadFrame]:
    found: list[Frame | BadFrame] = []
    end_s = time.monotonic() + 30.0
    while len(found) < count and time.monotonic() < end_s:
        capture = source.read(1.0)
        if capture is not None:
            found.append(capture)
    return found


@every(*SOURCES)
@pytest.mark.parametrize("options", RATES, ids=lambda options: options.mode)
def test_frames_have_the_stated_shape_units_and_time_and_stay_as_they_are(
    setup: Setup, options: CameraOptions
) -> None:
    with closing(setup.open(options)) as source:
        (first,) = captures(source, 1)
        assert isinstance(first, Frame)
        depth, ir = first.depth.copy(), first.ir.copy()
        frames = [first, *captures(source, 4)]
        np.testing.assert_array_equal(first.depth, depth)
        np.testing.assert_array_equal(first.ir, ir)
        lens, colour = source.camera.depth, source.camera.colour
    source.close()  # twice is fine
    assert source.camera.depth_mode == options.mode
    assert source.camera.fps == RATES[options]
    assert source.camera.serial
    assert len(frames) == 5
    for frame in frames:
        assert isinstance(frame, Frame)
        assert (frame.depth.shape, frame.depth.dtype) == ((lens.height, lens.width), np.uint16)
        assert (frame.ir.shape, frame.ir.dtype) == ((lens.height, lens.width), np.uint16)
        assert 300 < np.median(frame.depth[frame.depth > 0]) < 1500, "millimetres"
        assert np.median(frame.ir) > 100
        if isinstance(frame.colour, bytes):
            assert frame.colour.startswith(b"\xff\xd8"), "a JPEG"
        elif frame.colour is not None:
            assert colour is not None
            assert frame.colour.shape == (colour.height, colour.width, 3)
    times_us = [frame.time_us for frame in frames]
    assert (np.diff(times_us) > 0).all()
    if source.kind == "recording":
        assert np.diff(times_us) == pytest.approx(1e6 / source.camera.fps, abs=1000)
    else:
        assert abs(times_us[-1] - time.time_ns() // 1000) < 5_000_000, "Unix time"


@every(*DEVICES)
def test_an_unplugged_camera_is_lost_with_a_sentence_and_found_again(setup: Setup) -> None:
    source = setup.open(SMALL)
    assert source.camera.serial == "A"
    captures(source, 2)
    setup.unplug()
    with pytest.raises(SourceLost, match=r"went away: check its cable and its power"):
        for _ in range(20):
            source.read(0.01)
    source.close()
    again = replace(SMALL, serial="A")
    with pytest.raises(UserError, match=r"A is not plugged in"):
        setup.open(again)
    setup.plug()
    with closing(setup.open(again)) as source:
        assert source.camera.serial == "A"
        assert len(captures(source, 2)) == 2


@every(*DEVICES)
def test_another_camera_is_never_opened_in_place_of_the_named_one(setup: Setup) -> None:
    with closing(setup.open(replace(SMALL, serial="B"))) as source:
        assert source.camera.serial == "B"
    with pytest.raises(UserError, match=r"C is not plugged in.*,serial="):
        setup.open(replace(SMALL, serial="C"))


@every(*DEVICES)
@pytest.mark.parametrize("lacks", ["depth", "IR"])
def test_a_capture_without_an_image_is_a_bad_frame_among_good_ones(
    setup: Setup, lacks: str
) -> None:
    setup.spoil(2, lacks)
    with closing(setup.open(SMALL)) as source:
        first, bad, last = captures(source, 3)
    assert isinstance(first, Frame)
    assert isinstance(last, Frame)
    assert isinstance(bad, BadFrame)
    assert bad.reason == f"no {lacks} in this capture"


@every("recording", "switched", "bag")
def test_a_recording_has_an_end(setup: Setup) -> None:
    with closing(setup.open(SMALL)) as source, pytest.raises(EndOfSource):
        for _ in range(1000):
            source.read(3600.0)
