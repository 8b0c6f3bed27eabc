"""Femto cameras, as far as they can be tested without one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.settings import SourceSettings
from halo_service.sources.camera_name import CameraOptions
from halo_service.sources.orbbec import femto
from halo_service.sources.orbbec.bag import Bag
from halo_service.sources.orbbec.femto import Femto
from halo_service.sources.orbbec.sdk import PRODUCTS
from halo_service.sources.usb import CAMERAS, ORBBEC
from halo_service.sources.warm_up import warm_up_note
from halo_service.values import BadFrame, Frame
from tests.sources.cameras.orbbec_fake import FAKES, GEMINI, FakeDevice, OrbbecBench, real

BINNED = {"mode": "NFOV_2X2BINNED"}


@pytest.fixture
def bench(monkeypatch, small_camera, small_frames) -> OrbbecBench:
    monkeypatch.setenv("DISPLAY", ":0")
    return OrbbecBench(small_camera, small_frames)


def opened(bench: OrbbecBench, **options) -> Femto:
    return Femto("femto-bolt", CameraOptions(**(BINNED | options)), bench.sdk)


def test_the_installed_sdk_lists_no_device_and_prints_and_writes_nothing(tmp_path: Path) -> None:
    real()
    script = "from halo_service.sources.orbbec.sdk import load; print(load().plugged())"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    if done.stdout != "[]\n" and "Plugged(" in done.stdout:
        pytest.skip("there is an Orbbec camera plugged in")
    assert (done.stdout, done.stderr) == ("[]\n", "")
    assert list(tmp_path.iterdir()) == [], "the SDK's log is in the folder for temporary files"


def test_the_fakes_have_no_name_that_the_installed_sdk_lacks() -> None:
    module = real()
    for name, fake in FAKES.items():
        named = {each for each in vars(fake) if not each.startswith("_")}
        assert named <= set(dir(getattr(module, name))), name
    for group, names in {
        "OBFormat": ("Y16", "MJPG"),
        "OBSensorType": ("DEPTH_SENSOR", "IR_SENSOR", "COLOR_SENSOR"),
        "OBFrameAggregateOutputMode": ("FULL_FRAME_REQUIRE",),
        "OBPropertyID": (
            "OB_PROP_COLOR_AUTO_EXPOSURE_BOOL",
            "OB_PROP_COLOR_EXPOSURE_INT",
            "OB_PROP_COLOR_GAIN_INT",
            "OB_PROP_COLOR_POWER_LINE_FREQUENCY_INT",
        ),
        "OBPowerLineFreqMode": ("FREQUENCY_50HZ", "FREQUENCY_60HZ"),
        "OBMultiDeviceSyncMode": ("STANDALONE", "PRIMARY", "SECONDARY"),
        "OBCameraDistortionModel": ("BROWN_CONRADY_K6", "BROWN_CONRADY", "NONE"),
        "Context": ("set_logger_to_console", "set_logger_to_file"),
        "Config": ("enable_stream", "set_frame_aggregate_output_mode"),
        "OBPlaybackStatus": ("STOPPED", "PLAYING"),
    }.items():
        assert set(names) <= set(dir(getattr(module, group))), group


def test_the_usb_table_and_the_sdks_table_name_the_same_cameras() -> None:
    assert {
        product: kind for (vendor, product), (_, kind) in CAMERAS.items() if vendor == ORBBEC
    } == (PRODUCTS)


def test_the_factory_calibration_becomes_our_camera(bench: OrbbecBench, small_camera) -> None:
    camera = opened(bench).camera
    assert (camera.serial, camera.depth_mode, camera.fps) == ("A", "NFOV_2X2BINNED", 30)
    for lens, expected in (
        (camera.depth, small_camera.depth),
        (camera.colour, small_camera.colour),
    ):
        assert lens is not None
        assert (lens.width, lens.height) == (expected.width, expected.height)
        np.testing.assert_allclose(lens.matrix, expected.matrix, rtol=1e-6)
        np.testing.assert_allclose(lens.distortion, expected.distortion, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(
        camera.colour_from_depth, small_camera.colour_from_depth, rtol=1e-5, atol=1e-5
    )


def test_pixels_and_jpeg_are_the_devices_own(bench: OrbbecBench, small_frames) -> None:
    frame = opened(bench).read(1.0)
    assert isinstance(frame, Frame)
    np.testing.assert_array_equal(frame.depth, small_frames[1].depth)
    np.testing.assert_array_equal(frame.ir, small_frames[1].ir)
    assert frame.colour == small_frames[1].colour


def wrong_focus(bench):
    bench.profiles["DEPTH_SENSOR"].lens = bench.profiles["DEPTH_SENSOR"].lens.__class__(
        320, 288, 0.0, 0.0, 160.0, 144.0
    )


def wrong_model(bench):
    bench.profiles["COLOR_SENSOR"].model = bench.ob.OBCameraDistortionModel.KANNALA_BRANDT4


def wrong_pose(bench):
    bench.profiles["DEPTH_SENSOR"].extrinsic = bench.ob.OBExtrinsic()


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (wrong_focus, "reports no calibration of its depth lens"),
        (wrong_model, "unknown lens model KANNALA_BRANDT4"),
        (wrong_pose, "reports no pose of its colour camera"),
    ],
)
def test_a_calibration_that_cannot_be_used_is_refused(bench, spoil, says) -> None:
    spoil(bench)
    with pytest.raises(UserError, match=says):
        opened(bench)


def test_options_reach_the_device_and_a_known_role_is_not_written_again(bench) -> None:
    written = bench.devices[0].written
    opened(bench, exposure_ms=8.0, gain=90, power_line_hz=50)
    assert written == {
        "OB_PROP_COLOR_AUTO_EXPOSURE_BOOL": False,
        "OB_PROP_COLOR_EXPOSURE_INT": 80,
        "OB_PROP_COLOR_GAIN_INT": 90,
        "OB_PROP_COLOR_POWER_LINE_FREQUENCY_INT": 1,
    }
    assert bench.devices[0].sync_writes == 0
    for _ in range(2):
        opened(bench, sync="secondary", sync_delay_us=160)
    sync = bench.devices[0].sync
    assert sync.mode == bench.ob.OBMultiDeviceSyncMode.SECONDARY
    assert (sync.depth_delay_us, sync.color_delay_us) == (160, 160)
    assert bench.devices[0].sync_writes == 1
    opened(bench)
    assert written["OB_PROP_COLOR_AUTO_EXPOSURE_BOOL"] is True
    assert bench.devices[0].sync.mode == bench.ob.OBMultiDeviceSyncMode.STANDALONE


def test_the_exposure_can_be_set_while_it_runs(bench) -> None:
    source = opened(bench)
    source.expose(4.0)
    assert bench.devices[0].written["OB_PROP_COLOR_EXPOSURE_INT"] == 40
    source.expose(None)
    assert bench.devices[0].written["OB_PROP_COLOR_AUTO_EXPOSURE_BOOL"] is True


@pytest.mark.parametrize("lacks", ["torn depth", "torn IR"])
def test_a_torn_image_is_a_bad_frame(bench, lacks) -> None:
    bench.spoilt[1] = lacks
    bad = opened(bench).read(1.0)
    assert isinstance(bad, BadFrame)
    assert bad.reason == f"a {lacks} image"


def test_without_a_time_of_the_device_frames_have_that_of_their_arrival(bench, caplog) -> None:
    bench.zero_time = True
    source = opened(bench)
    times_us = [frame.time_us for frame in (source.read(1.0) for _ in range(3)) if frame]
    assert len(times_us) == 3
    assert (np.diff(times_us) > 0).all()
    assert caplog.text.count("sends no time of its own") == 1


def test_the_temperature_is_in_the_note_about_the_warm_up(bench) -> None:
    source = opened(bench)
    assert warm_up_note(source).startswith("cold (sensor 42 °C): distance may move by 2 mm")
    bench.devices[0].celsius = 0.0  # what a device reports that has no such sensor
    assert warm_up_note(source).startswith("cold: distance may move by 2 mm in the next 30 minutes")


def test_of_two_bolts_the_profiles_own_is_opened_and_again_after_a_loss(bench, monkeypatch) -> None:
    monkeypatch.setattr(femto, "load", bench.sdk)
    name = "femto-bolt,mode=NFOV_2X2BINNED"
    for serial, source in (("B", f"{name},serial=B"), ("B", name), ("A", f"{name},serial=A")):
        opened_one, _ = open_source(SourceSettings(source), "B" if source == name else "")
        assert opened_one.camera.serial == serial
    first, reopen = open_source(SourceSettings(name))
    assert first.camera.serial == "A"
    lost = bench.devices.pop(0)
    with pytest.raises(UserError, match="the Femto Bolt A is not plugged in; here: B"):
        reopen()
    bench.devices.append(lost)  # it comes back behind the other
    assert reopen().camera.serial == "A"


def test_another_model_is_named(bench) -> None:
    bench.devices = [FakeDevice(bench, "G", GEMINI, "Orbbec Gemini 335")]
    with pytest.raises(UserError, match=r"no Femto Bolt is plugged in .*Orbbec Gemini 335 G"):
        opened(bench)
    bench.devices = [FakeDevice(bench, "M", 0x0669, "Orbbec Femto Mega")]
    with pytest.raises(UserError, match=r"choose --source femto-mega"):
        opened(bench)


@pytest.mark.parametrize(
    ("mode", "lacks"),
    [("NFOV_UNBINNED", "640 x 576 at 30 fps"), ("WFOV_UNBINNED", "1024 x 1024 at 15 fps")],
)
def test_a_mode_that_the_firmware_lacks_is_named(bench, mode: str, lacks: str) -> None:
    with pytest.raises(UserError, match=f"has no DEPTH_SENSOR of {lacks}: update its firmware"):
        opened(bench, mode=mode)


def test_without_a_display_a_bolt_is_not_started_and_the_remedy_is_named(
    bench, monkeypatch
) -> None:
    monkeypatch.setenv("DISPLAY", "")
    with pytest.raises(UserError, match=r"depth engine needs a display.*xvfb-run -a halo serve"):
        opened(bench)
    assert bench.pipelines == [], "the SDK would end the whole program"


def test_the_reason_of_the_sdk_is_shown(bench) -> None:
    bench.start_fails = "Failed to open device: usb busy"
    with pytest.raises(UserError, match=r"cannot be started \(Failed to open device: usb busy\)"):
        opened(bench)


def test_a_mega_in_the_network_that_does_not_answer_is_one_sentence(bench) -> None:
    with pytest.raises(UserError, match=r"no Femto Mega answers at 192\.168\.1\.10"):
        Femto("femto-mega", CameraOptions(**BINNED, address="192.168.1.10"), bench.sdk)


def test_a_bag_that_the_sdk_cannot_play_is_one_sentence(tmp_path: Path) -> None:
    real()
    with pytest.raises(UserError, match="does not exist"):
        Bag(tmp_path / "no.bag", realtime=False)
    (tmp_path / "other.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(4000))
    with pytest.raises(UserError, match=r"other\.bag cannot be played by the SDK of Orbbec"):
        Bag(tmp_path / "other.bag", realtime=False)


def test_without_the_extra_the_error_names_the_command() -> None:
    script = (
        "import sys\n"
        "sys.modules['pyorbbecsdk'] = None\n"  # makes the import fail
        "from halo_service.errors import UserError\n"
        "from halo_service.sources.orbbec import sdk\n"
        "assert sdk.plugged() == []\n"
        "try:\n"
        "    sdk.load()\n"
        "except UserError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert "uv sync --extra orbbec" in done.stdout
