"""Frames: reproducible, honest, and as imperfect as they should be."""

import dataclasses

import cv2
import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.values import Finger, Frame, Side
from halo_service.virtual.bodies import cup
from halo_service.virtual.clock import START_US
from halo_service.virtual.hand import pointing
from halo_service.virtual.live_noise import READS, RENEWED
from halo_service.virtual.materials import MATERIALS
from halo_service.virtual.noise import DRIFT_MM
from halo_service.virtual.offline import SimulatedRecording, frames
from halo_service.virtual.pictures import show
from halo_service.virtual.room import Room, draw_room
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from halo_service.virtual.skeleton import FingerPose, posed
from tests.kind_sensor import KIND_ROOM, KIND_URL

QUIET = Room(**KIND_ROOM, noise=0.0)
WARM_US = -10_000_000_000
"""When a device was switched on that drifts no more."""


def hand_at(room, height_mm=0.0, force_g=25.0, x_mm=150.0, y_mm=100.0, **angles):
    aim = FingerPose(x_mm, y_mm, height_mm, force_g if height_mm == 0.0 else 0.0, **angles)
    return posed(room.user, pointing(room.user, room.dominant, aim))


def same(one: Frame, other: Frame) -> bool:
    return (
        one.time_us == other.time_us
        and np.array_equal(one.depth, other.depth)
        and np.array_equal(one.ir, other.ir)
        and np.array_equal(one.colour, other.colour)
    )


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    one, again, other = (list(frames(parse_sim_url("sim:demo", seed=s), 0.5)) for s in (5, 5, 6))
    for (frame, lines), (frame_again, lines_again) in zip(one, again, strict=True):
        assert lines == lines_again
        assert (frame is None) == (frame_again is None)
        assert frame is None or same(frame, frame_again)
    assert not same(one[0][0], other[0][0])


def test_a_frame_does_not_depend_on_the_frames_before_it():
    room = draw_room(3, **KIND_ROOM)
    hand = hand_at(room)
    first = Sensor(room)
    for k in range(3):
        first.frame(k, [hand])
    assert same(first.frame(99, [hand]), Sensor(room).frame(99, [hand]))


def test_depth_and_infrared_are_the_same_without_colour():
    room = draw_room(3)
    full, without = Sensor(room), Sensor(room)
    without.with_colour(False)
    one, other = (sensor.frame(1_000_000) for sensor in (full, without))
    assert one.colour is not None and other.colour is None
    assert np.array_equal(one.depth, other.depth) and np.array_equal(one.ir, other.ir)


def test_without_noise_live_depth_is_that_of_full_quality():
    request = parse_sim_url(f"sim:demo?noise=0&{KIND_URL}")
    scenario = start_scenario(request.scenario, request.room)
    full, live = (
        Sensor(request.room, colour_times=0, started_us=WARM_US, live=live)
        for live in (False, True)
    )
    for k in range(2 * READS):
        moment = scenario.at(2.0 + k / 30.0)
        one, other = (sensor.frame(k, moment.hands, moment.things) for sensor in (full, live))
        assert np.array_equal(one.depth, other.depth)
        if k < READS:  # infrared is noisy all the same; afterwards its images return
            assert np.array_equal(one.ir, other.ir)


def test_every_image_of_the_live_room_is_replaced_and_follows_the_drift():
    room = Room(**KIND_ROOM, noise=0.0)
    full, live = (Sensor(room, colour_times=0, live=live) for live in (False, True))
    hour_us = 3_600_000_000
    for k in range(READS):
        live.frame(k)  # cold
    for k in range(READS * RENEWED):
        live.frame(hour_us + k)
    warm = full.frame(hour_us).depth
    for k in range(READS):
        assert np.array_equal(live.frame(hour_us + k).depth, warm)


def test_live_frames_have_the_noise_of_full_quality():
    room, hand = Room(**KIND_ROOM), hand_at(Room(**KIND_ROOM))
    spreads, means = [], []
    for live in (False, True):
        sensor = Sensor(room, colour_times=0, started_us=WARM_US, live=live)
        frames = [sensor.frame(k, [hand]) for k in range(12 * READS)]
        for images in ([f.depth for f in frames], [f.ir for f in frames]):
            reads = np.array([image[150:450:3, 150:450:3] for image in images], dtype=np.float64)
            reads[reads == 0.0] = np.nan
            apart = np.diff(reads, axis=0)  # noise from frame to frame
            spreads.append(np.nanmedian(np.nanstd(apart, axis=0)))
            means.append(np.nanmean(reads, axis=0))
    assert spreads[2:] == pytest.approx(spreads[:2], rel=0.05)
    for full, live, spread in zip(means[:2], means[2:], spreads[:2], strict=True):
        assert np.nanstd(live - full) < 0.4 * spread


def test_one_seed_is_one_room_over_all_scenarios():
    for scenario in ("demo", "calibration", "pointing", "drumming"):
        assert parse_sim_url(f"sim:{scenario}", seed=9).room == draw_room(9)


def test_overriding_one_thing_leaves_the_others_as_they_were():
    drawn = draw_room(9)
    for change in ({"material": "foam"}, {"camera_height_mm": 510.0}, {"dominant": Side.LEFT}):
        assert draw_room(9, **change) == dataclasses.replace(drawn, **change)
    curve = draw_room(9, **{"curve.family": "sigmoid"}).curve
    assert curve == dataclasses.replace(drawn.curve, family="sigmoid")


def test_seeds_draw_different_people_and_places():
    rooms = [draw_room(seed) for seed in range(40)]
    assert {room.material for room in rooms} == {"paper", "wood", "suede", "plastic", "foam"}
    assert len({room.curve.family for room in rooms}) == 3
    assert {room.dominant for room in rooms} == {Side.LEFT, Side.RIGHT}
    heights = [room.camera_height_mm for room in rooms]
    assert 450.0 <= min(heights) < 490.0
    assert 590.0 < max(heights) <= 700.0


def test_a_frame_is_what_the_sdk_would_deliver():
    frame = Sensor(draw_room(1, **KIND_ROOM)).frame(123_456, [])
    assert frame.time_us == 123_456
    assert (frame.depth.shape, frame.depth.dtype) == ((576, 640), np.uint16)
    assert (frame.ir.shape, frame.ir.dtype) == ((576, 640), np.uint16)
    assert (frame.colour.shape, frame.colour.dtype) == ((720, 1280, 3), np.uint8)
    assert 0.1 < (frame.depth == 0).mean() < 0.4  # a real frame: about a quarter
    assert (frame.depth[230:430, 200:440] > 0).mean() > 0.99
    assert Sensor(QUIET, colour_times=0).frame(1).colour is None


def test_the_table_reads_as_far_as_it_is_but_for_the_devices_own_error():
    for seed in (1, 2, 3):
        room = draw_room(seed, material="paper", **KIND_ROOM)
        sensor = Sensor(room, colour_times=0, started_us=-10_000_000_000)
        mean = np.mean([sensor.frame(k).depth for k in range(20)], axis=0)
        error = (mean - sensor._imager.view.depth)[200:460, 180:460]
        assert abs(np.median(error)) < 3.0
        assert np.std(error) < 2.0


def test_noise_grows_as_infrared_falls():
    sensor = Sensor(Room(**KIND_ROOM, material="paper"), colour_times=0)
    reads = np.array([sensor.frame(k).depth for k in range(40)], dtype=np.float64)
    ir = sensor.frame(0).ir
    measured = (reads > 0).all(axis=0)
    spread = reads.std(axis=0)
    bright = spread[measured & (ir > 4000)].mean()
    dark = spread[measured & (ir < 1200)].mean()
    assert 0.4 < bright < 1.0
    assert dark > 1.2 * bright


def test_it_reads_nearer_when_cold():
    sensor = Sensor(QUIET, colour_times=0)
    cold, warm = (sensor.frame(int(t)).depth[300, 320] for t in (0, 3.6e9))
    assert int(warm) - int(cold) == pytest.approx(DRIFT_MM, abs=1)


def test_a_hand_reads_nearer_and_the_table_around_its_tip_farther():
    room = QUIET
    sensor = Sensor(room, colour_times=0)
    empty = sensor.frame(0).depth.astype(int)
    hand = hand_at(room)
    x, y = sensor.camera.depth.project(sensor.surface.to_camera(hand.pad(Finger.INDEX)[None]))[0]
    excess = sensor.frame(1, [hand]).depth.astype(int) - empty
    front = excess[round(y) - 11 : round(y) - 7, round(x) - 2 : round(x) + 3]
    assert front.mean() > 8.0
    back = excess[round(y) + 60 : round(y) + 80, round(x) - 5 : round(x) + 25]
    assert np.median(back) < -20.0


def test_outlines_read_nothing_or_something_in_between():
    sensor = Sensor(QUIET, colour_times=0)
    frame = sensor.frame(1, [hand_at(QUIET)])
    ideal = sensor._imager.draw([])
    inside = frame.depth[100:500, 120:520]
    assert 200 < (inside == 0).sum() < 4000
    assert ideal.covered.max() == 0


def test_a_finger_fades_into_the_table_before_its_halo_appears():
    sensor = Sensor(QUIET, colour_times=0)
    empty = sensor.frame(0).depth.astype(int)

    def lost(height):
        hand = hand_at(QUIET, height)
        tip = sensor.surface.to_camera(hand.joints[Finger.INDEX, 3:4])
        x, y = sensor.camera.depth.project(tip)[0]
        box = slice(round(y) - 10, round(y) + 6), slice(round(x) - 8, round(x) + 9)
        return (sensor.frame(1, [hand]).depth.astype(int) - empty)[box]

    assert (lost(60.0) < -60).mean() > 0.3  # stands out
    low = lost(12.0)
    assert ((low < -60) & (low > -400)).sum() == 0
    assert (low < -3).any()


@pytest.mark.parametrize("material", MATERIALS)
def test_every_material_can_be_seen(material):
    room = Room(**KIND_ROOM, material=material)
    frame = Sensor(room).frame(5, [hand_at(room)])
    valid = (frame.depth[200:400, 200:440] > 0).mean()
    assert valid > (0.5 if material == "mirror" else 0.95)
    assert frame.ir[300, 320] > 200


def test_a_cup_is_seen_in_depth_and_colour_and_a_sheet_in_colour_and_infrared():
    bare, laid = Sensor(Room(**KIND_ROOM, noise=0.0, material="suede")), Sensor(
        Room(**KIND_ROOM, noise=0.0, material="suede", props=("cup", "sheet", "board"))
    )  # fmt: skip
    before, after = bare.frame(1), laid.frame(1)
    changed = before.depth.astype(int) - after.depth
    assert changed.max() > 80
    assert (np.abs(before.ir.astype(int) - after.ir) > 300).sum() > (changed > 5).sum()
    moved = bare.frame(1, [], [cup(150.0, 100.0)])
    assert int(bare.frame(1).depth[300, 320]) - int(moved.depth[300, 320]) > 80


def test_projected_markers_are_seen_by_the_colour_camera_where_the_homography_puts_them():
    room = Room(**KIND_ROOM, projected="markers", material="paper", light=0.8)
    sensor = Sensor(room)
    image = sensor.frame(1).colour
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    corners, ids, _ = detector.detectMarkers(image)
    found = dict(zip(ids.ravel(), corners, strict=True))
    assert len(set(found) & set(range(8))) >= 6
    projector = room.projector
    side = projector.height_px // 4
    surface_from_projector = np.linalg.inv(projector.projector_from_surface())
    colour_from_surface = sensor.camera.colour_from_depth @ sensor.surface.camera_from_surface
    for number in set(found) & set(range(8)):
        x = projector.width_px * (2 * (number % 4) + 1) // 8 - side // 2
        y = projector.height_px * (2 * (number // 4) + 1) // 4 - side // 2
        place = surface_from_projector @ [x, y, 1.0]
        point = colour_from_surface @ [*(place[:2] / place[2]), 0.0, 1.0]
        px = sensor.camera.colour.project(point[None, :3])[0]
        assert found[number][0, 0] == pytest.approx(px, abs=1.5)


def test_projected_light_falls_on_the_hand_and_leaves_infrared_alone():
    dark, lit = (Room(**KIND_ROOM, projected=p) for p in ("dark", "colours"))
    hand = hand_at(dark)
    one, other = Sensor(dark).frame(1, [hand]), Sensor(lit).frame(1, [hand])
    assert np.array_equal(one.ir, other.ir)
    assert np.array_equal(one.depth, other.depth)
    assert np.abs(one.colour.astype(int) - other.colour).max() > 60


def test_a_dark_room_smears_moving_hands_and_overexposes_projected_light():
    dim = Room(**KIND_ROOM, light=0.2, noise=0.0, material="suede")
    still = hand_at(dim)
    moving = dataclasses.replace(still, velocity_mm_s=np.array([900.0, 0.0, 0.0]))
    sharp, smeared = (Sensor(dim).frame(1, [h]).colour.astype(int) for h in (still, moving))
    assert (np.abs(sharp - smeared).max(axis=2) > 20).sum() > 1000
    bright = Sensor(dataclasses.replace(dim, projected="markers")).frame(1).colour
    normal = Sensor(dataclasses.replace(dim, light=1.0, projected="markers")).frame(1).colour
    assert (bright == 255).mean() > (normal == 255).mean() + 0.02


def test_a_picture_that_is_none_gets_its_sentence(tmp_path):
    (tmp_path / "noise.png").write_bytes(b"no picture")
    for name, sentence in (
        ("absent", "finds no picture"),
        (str(tmp_path / "noise.png"), "cannot read"),
    ):
        with pytest.raises(UserError, match=sentence):
            Sensor(Room(**KIND_ROOM, projected=name))


def test_a_picture_file_is_thrown(tmp_path):
    path = tmp_path / "red.png"
    cv2.imwrite(str(path), np.full((20, 30, 3), (0, 0, 255), np.uint8))
    assert (show(str(path), 64, 40)(0.0) == (0, 0, 255)).all()


def test_dropped_frames_are_reported_and_time_goes_on():
    taken = list(frames(parse_sim_url(f"sim:idle?drop=0.3&seed=4&{KIND_URL}"), 4.0, colour=False))
    kept = [frame for frame, _ in taken if frame is not None]
    assert len(taken) == 120
    assert 60 < len(kept) < 105
    times = [frame.time_us for frame in kept]
    assert times[0] == START_US
    assert all(t % 1000 == 0 for t in times)
    assert min(np.diff(times)) > 25_000


def test_a_take_ends_by_itself_or_asks_for_its_length():
    with pytest.raises(UserError, match="never ends by itself"):
        SimulatedRecording(parse_sim_url("sim:demo"))
    for seconds in (0.0, -1.0, float("nan")):
        with pytest.raises(UserError, match="cannot be"):
            SimulatedRecording(parse_sim_url("sim:demo"), seconds)


def test_nothing_of_the_truth_is_in_a_frame():
    assert [f.name for f in dataclasses.fields(Frame)] == ["time_us", "depth", "ir", "colour"]


@pytest.mark.parametrize(
    "source", ["sim:chaos?seed=204", "sim:awkward?seed=213", "sim:ten-fingers"]
)
def test_moving_hands_leave_nothing_in_later_frames(source):
    """The images of the empty room are the same again after each frame."""
    request = parse_sim_url(source)
    scenario = start_scenario(request.scenario, request.room)
    used = Sensor(request.room, colour_times=0)
    moments = [scenario.at(0.4 * k) for k in range(20)]
    assert any(moment.hands for moment in moments)
    for k, moment in enumerate(moments):
        used.frame(400_000 * k, moment.hands, moment.things)
    for hands in ((), moments[-1].hands):
        again, fresh = (
            sensor.frame(8_000_000, hands)
            for sensor in (used, Sensor(request.room, colour_times=0))
        )
        assert (again.depth == fresh.depth).all()
        assert (again.ir == fresh.ir).all()


def test_a_frame_that_fails_leaves_nothing_behind(monkeypatch):
    request = parse_sim_url("sim:demo?seed=3")
    hands = start_scenario(request.scenario, request.room).at(2.0).hands
    sensor = Sensor(request.room, colour_times=0)
    with monkeypatch.context() as patched:
        patched.setattr("halo_service.virtual.sensor.cast_shadow", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            sensor.frame(0, hands)
    fresh = Sensor(request.room, colour_times=0)
    assert (sensor.frame(1_000, ()).depth == fresh.frame(1_000, ()).depth).all()
