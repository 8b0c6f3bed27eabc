"""The facts of the real sensor, each measured on frames of the virtual one."""

import dataclasses

import numpy as np
import pytest

from halo_service.sources.recording import Recording
from halo_service.virtual.bodies import block
from halo_service.virtual.facts import FACTS
from halo_service.virtual.hand import pointing
from halo_service.virtual.room import Room, draw_room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import KIND, TRUE
from halo_service.virtual.skeleton import FingerPose, User, posed
from halo_service.virtual.statements import Finding


def hand_over(room, height_mm, **angles):
    aim = FingerPose(150.0, 100.0, height_mm, **angles)
    return posed(room.user, pointing(room.user, room.dominant, aim))


def test_users_skin_reads_5_to_15_mm_too_far_and_differs():
    offsets = [draw_room(seed).user.skin_offset_mm for seed in range(400)]
    assert np.median(offsets) == pytest.approx(9.0, abs=0.5)
    assert np.log(offsets).std() == pytest.approx(0.27, abs=0.03)
    assert (min(offsets), max(offsets)) == (5.0, 15.0)


def test_a_hand_reads_as_far_as_the_users_offset_says_and_a_sleeve_reads_right():
    bare, covered = User(skin_offset_mm=0.0, sleeve_mm=30.0), User(sleeve_mm=30.0)
    frames = []
    for user in (bare, covered):
        room = Room(user=user, noise=0.0, sensor=TRUE, camera_height_mm=800.0)
        hand = hand_over(room, 60.0)
        frames.append(Sensor(room, colour_times=0).frame(1, [hand]).depth.astype(int))
    sensor = Sensor(room, colour_times=0)
    back = (hand.palm[0] + hand.palm[2]) / 2.0
    arm = hand.palm[0] + 0.6 * (hand.palm[0] - hand.palm[2])
    for place, offset in ((back, 9.0), (arm, 0.0)):
        x, y = sensor.camera.depth.project(sensor.surface.to_camera(place[None]))[0].round()
        box = slice(int(y) - 4, int(y) + 5), slice(int(x) - 4, int(x) + 5)
        further = frames[1][box] - frames[0][box]
        assert np.median(further) == pytest.approx(offset, abs=1.0)


@pytest.mark.parametrize("fact", FACTS, ids=lambda fact: fact.says)
def test_the_frames_show_what_is_known_of_the_real_sensor(fact):
    finding = Finding(fact, fact.measure())
    assert finding.holds, f"{finding.value:.3g} {fact.unit}, not {fact.least:g} to {fact.most:g}"


def test_the_noise_is_that_of_a_real_recording(company_data):
    """A flat part of the desk, of the mean infrared that the virtual table has at 0.95 m."""
    recording = Recording(company_data / "azure_kinect_desk.mkv", realtime=False, loop=False)
    desk = recording.read(1.0).depth[396:468, 408:480].astype(np.float64)
    recording.close()
    rows, columns = np.mgrid[:72, :72]
    plane = np.column_stack([np.ones(72**2), rows.ravel(), columns.ravel()])
    base, _ = np.linalg.qr(plane)
    noise = (desk.ravel() - base @ (base.T @ desk.ravel())).reshape(72, 72)
    named = {fact.says: fact for fact in FACTS}
    for px in (1, 2, 3, 4):
        real = (noise[:, :-px] * noise[:, px:]).mean() / noise.var()
        ours = named[f"correlation of the noise at {px} px"].measure()
        assert ours == pytest.approx(real, abs=0.07)
    assert named["depth noise of the recorded wall"].measure() == pytest.approx(
        noise.std(), rel=0.15
    )


def test_the_kind_sensor_has_white_noise_and_no_flicker():
    sensor = Sensor(Room(sensor=KIND), colour_times=0)
    reads = np.array([sensor.frame(k).depth for k in range(20)], dtype=np.float64)[
        :, 200:300, 200:300
    ]
    noise = reads - reads.mean(axis=0)
    assert abs((noise[:, :, 1:] * noise[:, :, :-1]).mean() / noise.var()) < 0.03
    assert (reads > 0).all()


def test_a_shadow_falls_on_one_side_and_reads_late_noisily_or_not_at_all():
    room = Room(sensor=TRUE, noise=0.0)
    sensor = Sensor(room, colour_times=0)
    x = sensor.surface.from_camera(np.array([[0.0, 0.0, 500.0]]))[0, 0]
    tall = [block(x, -100.0, 60.0, 400.0, 100.0)]
    rows = slice(310, 350)
    empty, full = sensor.frame(0), sensor.frame(1, (), tall)
    dark = full.ir[rows] < 0.4 * empty.ir[rows]
    left, right = dark[:, :322], dark[:, 400:]
    assert left.sum() > 3 * 40
    assert right.sum() == 0
    shade = full.depth[rows, :322][left].astype(float)
    assert 0.15 < (shade == 0).mean() < 0.8
    assert np.std(shade[shade > 0]) > 3.0


def test_a_low_finger_in_motion_is_mixed_and_a_high_one_is_invalidated():
    room = Room(sensor=TRUE, noise=0.0)
    sensor = Sensor(room, colour_times=0)

    def lost(height, speed):
        hand = dataclasses.replace(
            hand_over(room, height), velocity_mm_s=np.array([speed, 0.0, 0.0])
        )
        x, y = sensor.camera.depth.project(sensor.surface.to_camera(hand.joints[1, 3:4]))[0]
        box = slice(round(y) - 10, round(y) + 5), slice(round(x) - 25, round(x) + 25)
        return np.count_nonzero(sensor.frame(1, [hand]).depth[box] == 0)

    assert lost(60.0, 600.0) > 2 * lost(60.0, 0.0)
    assert lost(0.0, 600.0) < 10
