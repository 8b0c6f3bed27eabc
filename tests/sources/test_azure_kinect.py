"""The live Kinect, as far as it can be tested without one."""

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.settings import SourceSettings
from halo_service.sources import azure_kinect
from halo_service.sources.azure_kinect import AzureKinect, connected, outcome
from halo_service.sources.clock import DeviceClock
from halo_service.sources.recording import Recording
from halo_service.values import BadFrame, Frame
from halo_service.virtual.camera import factory

REAL = Path(__file__).parents[2] / "../shared/data/azure_kinect_desk.mkv"


def pyk4a():
    return pytest.importorskip("pyk4a", reason="the Azure Kinect SDK is not installed")


def without_a_camera():
    if connected():
        pytest.skip("there is an Azure Kinect plugged in")


def test_opening_a_camera_that_is_not_there_is_one_sentence():
    pyk4a()
    without_a_camera()
    with pytest.raises(UserError, match="no Azure Kinect is plugged in"):
        AzureKinect()


def test_looking_for_a_camera_prints_nothing():
    script = "from halo_service.sources.azure_kinect import connected; print(connected())"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip().isdigit()
    assert done.stderr == ""


def test_without_the_sdk_there_is_no_camera_and_the_error_gives_the_reason():
    script = (
        "import sys\n"
        "sys.modules['pyk4a'] = None\n"  # makes the import fail
        "from halo_service.errors import UserError\n"
        "from halo_service.sources.azure_kinect import AzureKinect, connected\n"
        "assert connected() == 0\n"
        "try:\n"
        "    AzureKinect()\n"
        "except UserError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert "(pyk4a) is not installed" in done.stdout


@pytest.fixture
def capture():
    """A capture as the SDK delivers it, from its own playback of a real recording."""
    if not REAL.exists():
        pytest.skip("no shared/data/azure_kinect_desk.mkv")
    with pyk4a().PyK4APlayback(REAL) as playback:
        yield playback.get_next_capture()


def test_a_capture_becomes_a_frame_with_its_jpeg_untouched(capture):
    before_us = time.time_ns() // 1000
    frame = outcome(capture, DeviceClock())
    after_us = time.time_ns() // 1000
    recording = Recording(REAL, realtime=False, loop=False)
    same = recording.read(0)
    recording.close()
    assert isinstance(frame, Frame)
    assert isinstance(same, Frame)
    np.testing.assert_array_equal(frame.depth, same.depth)
    np.testing.assert_array_equal(frame.ir, same.ir)
    assert frame.colour == same.colour
    assert before_us <= frame.time_us <= after_us


@pytest.mark.parametrize(("lacks", "says"), [("depth", "no depth"), ("ir", "no IR")])
def test_a_capture_that_lacks_an_image_is_a_bad_frame(capture, lacks, says):
    class Lacking:
        """The same capture, as it is when the camera did not deliver one of its images."""

        depth = None if lacks == "depth" else capture.depth
        ir = None if lacks == "ir" else capture.ir
        color = capture.color

    bad = outcome(Lacking(), DeviceClock())
    assert isinstance(bad, BadFrame)
    assert bad.reason == f"{says} in this capture"
    assert abs(bad.time_us - time.time_ns() // 1000) < 1_000_000


class TwoCameras:
    """The SDK with two cameras; `busy` and `failing` are serial numbers."""

    class K4AException(Exception):  # noqa: N818 - the SDK's name
        pass

    class K4ATimeoutException(K4AException):
        pass

    class ImageFormat:
        COLOR_MJPG = 0

    class ColorResolution:
        RES_720P = 1

    class DepthMode:
        NFOV_UNBINNED = 2

    class FPS:
        FPS_30 = 2

    def __init__(self, serials=("A", "B"), busy=(), failing=()):
        self.serials, self.busy, self.failing = serials, busy, failing
        self.closed = []

    def connected_device_count(self):
        return len(self.serials)

    def Config(self, **_):  # noqa: N802 - the SDK's name
        return None

    def PyK4A(self, config, device_id, thread_safe):  # noqa: N802 - the SDK's name
        return Device(self, self.serials[device_id])


class Device:
    """One of them."""

    def __init__(self, sdk, serial):
        self.sdk, self.serial = sdk, serial

    def open(self):
        if self.serial in self.sdk.busy:
            raise self.sdk.K4AException

    def start(self):
        if self.serial in self.sdk.failing:
            raise self.sdk.K4AException

    def stop(self):
        pass

    def close(self):
        self.sdk.closed.append(self.serial)

    @property
    def calibration_raw(self):
        return k4a.to_json(replace(factory(), serial=self.serial)).decode()


@pytest.mark.parametrize(
    ("wanted", "busy", "opened"),
    [("", (), "A"), ("A", (), "A"), ("B", (), "B"), ("", ("A",), "B"), ("B", ("A",), "B")],
)
def test_of_two_cameras_the_one_of_the_profile_is_opened(monkeypatch, wanted, busy, opened):
    sdk = TwoCameras(busy=busy)
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: sdk)
    camera = AzureKinect(wanted)
    assert camera.camera.serial == opened
    assert opened not in sdk.closed
    assert open_source(SourceSettings(f"azure-kinect:{opened}"))[0].camera.serial == opened
    assert open_source(SourceSettings("azure-kinect"), opened)[0].camera.serial == opened


def test_a_lost_camera_is_opened_again_and_never_the_other_one(monkeypatch):
    sdk = TwoCameras(busy=("A",))
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: sdk)
    source, reopen = open_source(SourceSettings("auto"))
    sdk.busy = ()
    assert source.camera.serial == reopen().camera.serial == "B"


def test_a_camera_that_is_not_there_is_named_with_those_that_are(monkeypatch):
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: TwoCameras(busy=("A",)))
    with pytest.raises(UserError, match=r"Azure Kinect C is not plugged in.*azure-kinect:B"):
        AzureKinect("C")


LOG = (
    "\n[2026] [error] [t=1] /src/usb.c (1037): usb_cmd_get_device_count(). No devices found\n"
    "[2026] [error] [t=1] /src/x.c (68): usb_cmd_create(A, B) returned failure in depth()\n"
)
ENGINE = (
    "[2026] [critical] [t=1] /src/dewrapper.c (154): depth_engine_start_helper(). Depth engine "
    "create and initialize failed with error code: 204.\n"
)


@pytest.mark.parametrize(
    ("logged", "display", "says"),
    [
        ("", "", r"cannot be started: close other programs"),
        (LOG, "", r"cannot be started \(No devices found\): close other programs"),
        (LOG + ENGINE, "", r"error code: 204.*needs a display and DISPLAY is not set"),
        (LOG + ENGINE, ":0", r"error code: 204.*: close other programs"),
    ],
)
def test_the_reason_of_the_sdk_is_shown(monkeypatch, tmp_path, logged, display, says):
    log = tmp_path / "k4a.log"
    log.write_text("[2026] [critical] [t=1] /src/a.c (1): a(). what went wrong before\n")

    class Failing(TwoCameras):
        def PyK4A(self, *rest, **named):  # noqa: N802 - the SDK's name
            with log.open("a") as file:
                file.write(logged)
            return super().PyK4A(*rest, **named)

    monkeypatch.setattr(azure_kinect, "_sdk", lambda: Failing(failing=("A", "B")))
    monkeypatch.setattr(azure_kinect, "_LOG", log)
    monkeypatch.setenv("DISPLAY", display)
    with pytest.raises(UserError, match=says):
        AzureKinect()
