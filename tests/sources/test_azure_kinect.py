"""The live Kinect, as far as it can be tested without one."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.sources.azure_kinect import AzureKinect, connected, outcome
from halo_service.sources.clock import DeviceClock
from halo_service.sources.recording import Recording
from halo_service.values import BadFrame, Frame

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
