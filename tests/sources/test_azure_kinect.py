"""The live Kinect, as far as it can be tested without one."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.settings import SourceSettings
from halo_service.sources import azure_kinect
from halo_service.sources.azure_kinect import AzureKinect, connected, outcome
from halo_service.sources.camera_name import CameraOptions
from halo_service.sources.clock import DeviceClock
from halo_service.sources.recording import Recording
from halo_service.values import BadFrame, Frame
from halo_service.virtual.camera import factory
from tests.sources.cameras.kinect_fake import FakePyK4A, KinectBench

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


def cameras(**given) -> KinectBench:
    return KinectBench(factory(), **given)


@pytest.mark.parametrize(
    ("wanted", "busy", "opened"),
    [("", (), "A"), ("A", (), "A"), ("B", (), "B"), ("", ("A",), "B"), ("B", ("A",), "B")],
)
def test_of_two_cameras_the_one_of_the_profile_is_opened(monkeypatch, wanted, busy, opened):
    sdk = cameras(busy=busy)
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: sdk)
    camera = AzureKinect(CameraOptions(serial=wanted))
    assert camera.camera.serial == opened
    assert opened not in sdk.closed
    assert open_source(SourceSettings(f"azure-kinect:{opened}"))[0].camera.serial == opened
    assert open_source(SourceSettings("azure-kinect"), opened)[0].camera.serial == opened


def test_a_lost_camera_is_opened_again_and_never_the_other_one(monkeypatch):
    sdk = cameras(busy=("A",))
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: sdk)
    source, reopen = open_source(SourceSettings("auto"))
    sdk.busy = ()
    assert source.camera.serial == reopen().camera.serial == "B"


def test_a_camera_that_is_not_there_is_named_with_those_that_are(monkeypatch):
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: cameras(busy=("A",)))
    with pytest.raises(UserError, match=r"Azure Kinect C is not plugged in.*azure-kinect,serial=B"):
        AzureKinect(CameraOptions(serial="C"))


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

    class Failing(KinectBench):
        def PyK4A(self, *rest, **named):  # noqa: N802 - the SDK's name
            with log.open("a") as file:
                file.write(logged)
            return super().PyK4A(*rest, **named)

    monkeypatch.setattr(azure_kinect, "_sdk", lambda: Failing(factory(), failing=("A", "B")))
    monkeypatch.setattr(azure_kinect, "_LOG", log)
    monkeypatch.setenv("DISPLAY", display)
    with pytest.raises(UserError, match=says):
        AzureKinect()


def test_options_reach_the_device(monkeypatch):
    sdk = cameras()
    monkeypatch.setattr(azure_kinect, "_sdk", lambda: sdk)
    AzureKinect(
        CameraOptions(
            mode="WFOV_UNBINNED",
            exposure_ms=8.0,
            gain=90,
            power_line_hz=60,
            sync="secondary",
            sync_delay_us=160,
        )
    )
    assert sdk.configs[0]["depth_mode"] == sdk.DepthMode.WFOV_UNBINNED
    assert sdk.configs[0]["camera_fps"] == sdk.FPS.FPS_15
    assert sdk.configs[0]["wired_sync_mode"] == sdk.WiredSyncMode.SUBORDINATE
    assert sdk.configs[0]["subordinate_delay_off_master_usec"] == 160
    (device,) = sdk.devices
    assert (device.exposure, device.gain, device.powerline_frequency) == (8000, 90, 2)


def test_the_fake_has_no_name_that_the_installed_sdk_lacks():
    real = pyk4a()
    named = {name for name in vars(KinectBench(factory()).__class__) if not name.startswith("_")}
    assert named - {"capture"} <= set(dir(real))
    for group in ("ImageFormat", "ColorResolution", "DepthMode", "FPS", "WiredSyncMode"):
        assert set(vars(getattr(KinectBench, group))) <= set(dir(getattr(real, group))), group
    ours = set(vars(FakePyK4A(None, ""))) | set(vars(FakePyK4A)) - {"bench", "shown"}
    used = {name for name in ours if not name.startswith("_")} - {"bench", "shown"}
    assert used <= set(dir(real.PyK4A)) | {"is_running"}
    assert "is_running" in vars(real.PyK4A())
    capture = vars(
        KinectBench(factory(), [Frame(0, *[np.zeros((2, 2), np.uint16)] * 2, b"")]).capture(0)
    )
    assert set(capture) <= set(dir(real.PyK4ACapture))
    assert real.Config(
        wired_sync_mode=real.WiredSyncMode.SUBORDINATE, subordinate_delay_off_master_usec=160
    ).unpack()
