"""Other devices, modes, heights and clocks: the same scene comes out right through each."""

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.outputs.recorder import Recorder
from halo_service.sources.clock import DeviceClock
from halo_service.sources.recording import Recording
from halo_service.values import Finger
from halo_service.virtual.camera import DEVICES, MODES, factory, pixel_rays
from halo_service.virtual.clock import clock_of
from halo_service.virtual.hand import pointing
from halo_service.virtual.live import VirtualKinect
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import TRUE
from halo_service.virtual.sim_url import parse_sim_url
from halo_service.virtual.skeleton import FingerPose, posed

EVERY = [(device, mode) for device in DEVICES for mode in MODES]
SIZES = {
    "NFOV_UNBINNED": (640, 576),
    "NFOV_2X2BINNED": (320, 288),
    "WFOV_2X2BINNED": (512, 512),
    "WFOV_UNBINNED": (1024, 1024),
}


@pytest.mark.parametrize("device, mode", EVERY)
def test_every_lit_pixel_has_a_ray_that_comes_back_to_it(device, mode):
    lens = factory(device, mode).depth
    assert (lens.width, lens.height) == SIZES[mode]
    rows, columns = np.mgrid[: lens.height, : lens.width]
    px = np.column_stack([columns.ravel(), rows.ravel()])
    lit = np.hypot(*(px - (lens.cx, lens.cy)).T) < MODES[mode].field * lens.height / 2.0
    back = lens.project(pixel_rays(lens).reshape(-1, 3)[lit])
    assert np.abs(back - px[lit]).max() < 0.02


@pytest.mark.parametrize("device, mode", EVERY)
def test_the_calibration_file_gives_the_same_camera_back(device, mode):
    camera = factory(device, mode)
    again = k4a.from_json(
        k4a.to_json(camera), depth_mode=mode, colour_resolution="720P", fps=camera.fps
    )
    assert (again.serial, again.depth_mode) == (camera.serial, mode)
    point = np.array([[40.0, -30.0, 500.0]])
    assert again.depth.project(point) == pytest.approx(camera.depth.project(point))
    assert again.colour_from_depth == pytest.approx(camera.colour_from_depth)


def test_a_binned_mode_sees_the_same_rays_in_half_as_many_pixels():
    point = np.array([[80.0, 50.0, 600.0]])
    full, half = (factory("bolt", mode).depth for mode in ("NFOV_UNBINNED", "NFOV_2X2BINNED"))
    assert half.project(point)[0] == pytest.approx((full.project(point)[0] + 0.5) / 2.0 - 0.5)


@pytest.mark.parametrize("device, mode", EVERY)
@pytest.mark.parametrize("height_mm, pitch_deg", [(350.0, 20.0), (500.0, -20.0), (1000.0, 0.0)])
def test_a_hand_is_where_the_lens_says_at_every_height_tilt_and_mode(
    device, mode, height_mm, pitch_deg
):
    room = Room(
        sensor=TRUE,
        device=device,
        mode=mode,
        camera_height_mm=height_mm,
        camera_pitch_deg=pitch_deg,
        noise=0.0,
    )
    sensor = Sensor(room, colour_times=0)
    hand = posed(room.user, pointing(room.user, room.dominant, FingerPose(150.0, 100.0, 40.0)))
    empty, full = sensor.frame(1), sensor.frame(2, [hand])
    assert full.depth.shape == SIZES[mode][::-1]
    tip = hand.joints[Finger.INDEX, 3] - (0.0, 0.0, hand.radii[Finger.INDEX, 3])
    x, y = sensor.camera.depth.project(sensor.surface.to_camera(tip[None]))[0].round().astype(int)
    excess = full.depth[y - 1 : y + 2, x - 1 : x + 2].astype(int) - empty.depth[y, x]
    # The upper side is the finger's thickness and 40 mm high; skin reads 9 mm too far.
    assert -75 < np.median(excess) < -25
    middle = empty.depth[round(sensor.camera.depth.cy), round(sensor.camera.depth.cx)]
    assert int(middle) == pytest.approx(height_mm, abs=6.0)


@pytest.mark.parametrize("device, mode", EVERY)
def test_a_device_runs_at_the_rate_of_its_mode(device, mode):
    room = Room(device=device, mode=mode)
    assert room.camera().fps == k4a.DEPTH_FPS[mode]
    assert clock_of(room, "idle").fps == pytest.approx(room.camera().fps, rel=0.005)


@pytest.mark.parametrize(
    "device, mode",
    [("kinect", "NFOV_2X2BINNED"), ("bolt", "NFOV_2X2BINNED"), ("bolt", "WFOV_UNBINNED")],
)
def test_a_recording_in_another_mode_is_read_back_as_it_was_drawn(tmp_path, device, mode):
    url = f"sim:idle?sensor=true&device={device}&mode={mode}&drop=0&seed=3"
    recording = SimulatedRecording(parse_sim_url(url), 0.2)
    path = tmp_path / "binned.mkv"
    with Recorder(path, recording.camera, fps=recording.camera.fps, colour=True) as recorder:
        drawn = [frame for frame, _ in recording if frame is not None]
        for frame in drawn:
            recorder.write(frame)
    assert len(drawn) == 0.2 * k4a.DEPTH_FPS[mode]
    recording = Recording(path, realtime=False, loop=False)
    assert (recording.camera.depth_mode, recording.camera.fps) == (mode, k4a.DEPTH_FPS[mode])
    for frame in drawn:
        read = recording.read(1.0)
        assert read.time_us == frame.time_us
        assert np.array_equal(read.depth, frame.depth)
    recording.close()


def test_the_services_clock_follows_a_device_that_drifts():
    room = Room(sensor=TRUE, device="bolt")
    clock, mapping = clock_of(room, "idle"), DeviceClock()
    start_us = 1_795_000_000_000_000
    rng = np.random.default_rng(1)
    errors = []
    for index in range(9000):
        host_us = start_us + round(clock.exposed_s(index) * 1e6)
        delay_us = 20_000 + round(rng.exponential(4_000))
        device_us = clock.device_us(clock.exposed_s(index))
        errors.append(mapping.unix_us(device_us, host_us + delay_us) - host_us - 20_000)
    assert np.abs(errors[300:]).max() < 6_000


def test_each_start_of_a_bolt_has_a_clock_of_its_own():
    rooms = [Room(seed=seed, device="bolt", sensor=TRUE) for seed in range(20)]
    starts = {clock_of(room, scenario).start_us for room in rooms for scenario in ("idle", "demo")}
    assert len(starts) == 40
    assert any(start < 3_600_000_000 for start in starts)
    assert any(start > 1_500_000_000_000_000 for start in starts)


def test_truth_and_frames_are_on_the_devices_clock():
    recording = SimulatedRecording(
        parse_sim_url("sim:demo?sensor=true&device=bolt&drop=0"), 6.0, colour=False
    )
    contacts, times = [], []
    for frame, lines in recording:
        contacts += [line["contact"] for line in lines if "contact" in line]
        if frame is not None:
            times.append(frame.time_us)
    assert contacts
    for contact in contacts:
        assert times[0] < contact["from_us"] < contact["to_us"] < times[-1]


def test_a_live_camera_runs_in_another_mode():
    url = "sim:idle?sensor=true&device=bolt&mode=WFOV_2X2BINNED"
    with VirtualKinect(parse_sim_url(url), colour=False) as kinect:
        assert kinect.camera.depth_mode == "WFOV_2X2BINNED"
        frame = None
        while frame is None:
            frame = kinect.read(1.0)
        assert frame.depth.shape == (512, 512)
        assert int(frame.depth[258, 261]) > 300


@pytest.mark.parametrize(
    "option, sentence", [("mode=WIDE", "'WIDE'"), ("device=webcam", "'webcam'")]
)
def test_an_unknown_device_or_mode_gets_its_sentence(option, sentence):
    with pytest.raises(UserError, match=sentence):
        parse_sim_url(f"sim:demo?{option}")
