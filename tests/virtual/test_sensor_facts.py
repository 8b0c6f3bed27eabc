"""The facts of the real sensor, each measured on frames of the virtual one."""

import numpy as np
import pytest

from halo_service.virtual.hand import pointing
from halo_service.virtual.room import Room, draw_room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import TRUE
from halo_service.virtual.skeleton import FingerPose, User, posed


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
