"""Users that a seed draws: wider hands on every side of the table, one user in all scenarios."""

import dataclasses

import numpy as np
import pytest

from halo_service.values import Finger, Side
from halo_service.virtual import appearance
from halo_service.virtual.hand import pointing
from halo_service.virtual.materials import MATERIALS, STUDIED
from halo_service.virtual.room import Room, draw_room
from halo_service.virtual.scenarios import SCENARIOS, start_scenario
from halo_service.virtual.scenarios.common import away, from_seat
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import KIND, TRUE
from halo_service.virtual.sim_url import parse_sim_url
from halo_service.virtual.skeleton import FingerPose, User, posed

ROOMS = [draw_room(seed, sensor=TRUE) for seed in range(120)]
AIM = FingerPose(150.0, 100.0, 0.0, 50.0, 45.0, 0.0)


def hand_of(user, aim=AIM, side=Side.RIGHT):
    return posed(user, pointing(user, side, aim, curl=user.curl))


def test_hands_and_halos_cover_their_ranges():
    users, curves = [room.user for room in ROOMS], [room.curve for room in ROOMS]
    assert {user.girth for user in users} == {0.85, 0.92, 1.0, 1.08, 1.15}
    curls = np.array([user.curl for user in users])
    assert np.mean(curls == 0.0) > 0.1
    assert np.mean(curls == 1.0) > 0.1
    assert np.mean((curls > 0.1) & (curls < 0.9)) > 0.3
    assert {room.dominant for room in ROOMS} == {Side.LEFT, Side.RIGHT}
    assert {round(room.seat_deg / 90.0) % 4 for room in ROOMS} == {0, 1, 2, 3}
    assert any(user.nail_over_mm >= 5.0 for user in users)
    assert any(user.rings for user in users)
    assert min(user.sleeve_mm for user in users if user.sleeve_mm is not None) < 0.0
    assert {curve.shape for curve in curves} == {"bell", "odd"}
    assert max(curve.corner_fall for curve in curves) > 0.4
    powers = [curve.press_power for curve in curves if curve.press_power]
    assert 0.5 <= min(powers) < 0.6 < 0.9 < max(powers) <= 1.0
    odd = [curve for curve in curves if curve.shape == "odd"]
    assert all(1.0 <= curve.shift_mm <= 5.0 and 1.2 <= curve.stretch <= 1.8 for curve in odd)
    assert all(abs(curve.lopsided) <= 0.3 and 1.0 <= curve.glow_mm <= 2.0 for curve in odd)


def test_some_skin_is_as_bright_as_each_table():
    for name in STUDIED:
        material = MATERIALS[name]
        like = [
            room
            for room in ROOMS
            if abs(room.user.skin / material.infrared - 1.0) < 0.06
            and abs(np.mean(room.user.tone) / np.mean(material.colour) - 1.0) < 0.1
        ]
        assert like, name


@pytest.mark.parametrize("seed", [*range(213, 219), *range(313, 325)])
def test_one_seed_is_one_user_in_every_scenario_and_on_every_material(seed):
    drawn = draw_room(seed, sensor=TRUE)
    for scenario in ("threshold", "awkward", "typing", "ten-fingers", "pointing"):
        for material in STUDIED:
            room = parse_sim_url(f"sim:{scenario}?seed={seed}&material={material}&sensor=true").room
            assert room == dataclasses.replace(drawn, material=material)


def test_the_kind_sensor_has_plain_users():
    for seed in range(40):
        room = draw_room(seed, sensor=KIND)
        assert room.seat_deg == 0.0
        assert room.curve.shape == "bell"
        assert (room.user.rings, room.user.nail_over_mm, room.user.thumb_out) == ((), 0.0, 0.0)


OPTIONS = {
    "girth=1.15": "user.girth",
    "curl=0": "user.curl",
    "thumb_out=0.7": "user.thumb_out",
    "nail_over_mm=6": "user.nail_over_mm",
    "sleeve_mm=none": "user.sleeve_mm",
    "sleeve_infrared=0.3": "user.sleeve_infrared",
    "rings=ring,middle": "user.rings",
    "seat_deg=180": "seat_deg",
    "shift_mm=4": "curve.shift_mm",
    "stretch=1.6": "curve.stretch",
    "lopsided=-0.2": "curve.lopsided",
    "glow_mm=1.5": "curve.glow_mm",
    "glow_reach_mm=30": "curve.glow_reach_mm",
    "wider_high=0.4": "curve.wider_high",
    "wider_pressed=0.2": "curve.wider_pressed",
    "corner_fall=0.4": "curve.corner_fall",
    "corner=2": "curve.corner",
    "press_power=0.6": "curve.press_power",
    "press_saturates=yes": "curve.press_saturates",
}


@pytest.mark.parametrize("option", OPTIONS)
def test_each_property_is_set_by_its_name_alone(option):
    drawn, room = draw_room(4), parse_sim_url(f"sim:demo?seed=4&{option}").room
    part, _, field = OPTIONS[option].rpartition(".")
    before, after = (getattr(each, part) if part else each for each in (drawn, room))
    value = option.partition("=")[2]
    got = getattr(after, field)
    read = {"none": None, "yes": True, "ring,middle": (Finger.RING, Finger.MIDDLE)}
    assert got == read.get(value, float(value) if value not in read else None)
    assert dataclasses.replace(after, **{field: getattr(before, field)}) == before


@pytest.mark.parametrize(
    ("option", "sentence"),
    [
        ("rings=toe", "rings is 'toe'; it must be names of fingers"),
        ("press_saturates=maybe", "it must be yes or no"),
        ("sleeve_mm=long", "it must be a number or none"),
        ("corner=4", "give 0 to 3"),
    ],
)
def test_a_value_that_makes_no_sense_is_rejected(option, sentence):
    with pytest.raises(Exception, match=sentence):
        parse_sim_url(f"sim:demo?{option}")


def test_hanging_fingers_are_low_and_a_fist_is_high():
    def lowest(curl):
        hand = hand_of(User(curl=curl))
        return max(hand.pad(f)[2] for f in Finger if f is not Finger.INDEX)

    assert -8.0 < lowest(0.0) < -3.0  # hanging, and still clear of the table
    assert lowest(1.0) < -15.0


def test_a_thumb_spreads_out():
    def gap(out):
        hand = hand_of(User(thumb_out=out))
        return np.linalg.norm(hand.joints[Finger.THUMB, 3] - hand.joints[Finger.INDEX, 1])

    assert gap(1.0) > gap(0.5) + 8.0 > gap(0.0) + 16.0


def test_girth_widens_the_finger_and_leaves_the_pad():
    def width(girth):
        hand = hand_of(User(girth=girth))
        tip = hand.vertices[np.linalg.norm(hand.vertices - hand.joints[1, 3], axis=1) < 12.0]
        return np.ptp(tip[:, 0])

    assert 1.25 < width(1.15) / width(0.85) < 1.45
    for girth in (0.85, 1.15):
        assert hand_of(User(girth=girth)).pad(Finger.INDEX)[:2] == pytest.approx([150.0, 100.0])


@pytest.mark.parametrize("pitch", [20.0, 45.0, 80.0])
def test_long_nails_reach_beyond_the_tip_and_never_below_the_table(pitch):
    aim = dataclasses.replace(AIM, pitch_deg=pitch, force_g=0.0)
    short, long = hand_of(User(), aim), hand_of(User(nail_over_mm=8.0), aim)
    assert long.pad(Finger.INDEX) == pytest.approx(short.pad(Finger.INDEX))
    new = long.vertices[len(short.vertices) :]
    assert new[:, 2].max() < 0.0
    if pitch < 60.0:  # seen from above; a steep nail points down
        assert short.vertices[:, 1].min() - new[:, 1].min() > 3.0


def test_rings_and_sleeves_look_like_metal_and_cloth():
    user = User(rings=(Finger.RING,), sleeve_mm=-20.0, sleeve_infrared=0.3)
    infrared = appearance.infrared(user)
    assert 4 <= np.count_nonzero(infrared == np.float32(appearance.RING_INFRARED)) < 120
    bare = np.count_nonzero(appearance.infrared(User()) == np.float32(0.3))
    assert np.count_nonzero(infrared == np.float32(0.3)) > bare + 200


@pytest.mark.parametrize("seat", [0.0, 70.0, 90.0, 180.0, 270.0])
def test_the_arm_comes_from_the_users_edge_and_the_pad_stays(seat):
    room = Room(seat_deg=seat)
    for scenario in ("pointing", "chaos", "ten-fingers"):
        running = start_scenario(scenario, room)
        for t_s in (4.0, 5.0, 6.0):
            for hand in running.at(t_s).hands:
                arm = hand.palm[0] - hand.palm[2]  # from the middle knuckle to the wrist
                towards = np.array([-np.sin(np.radians(seat)), np.cos(np.radians(seat))])
                assert arm[:2] @ towards > 0.5 * np.linalg.norm(arm[:2])


@pytest.mark.parametrize("seed", [213, 214, 215, 216, 313, 318])
def test_a_hand_out_of_view_leaves_no_trace_from_any_side(seed):
    for seat in (0.0, 90.0, 180.0, 270.0):
        room = draw_room(seed, sensor=TRUE, seat_deg=seat, camera_height_mm=600.0)
        sensor = Sensor(room, colour_times=0)
        aim = dataclasses.replace(away(room, room.dominant), yaw_deg=seat)
        empty, with_hand = sensor.frame(1), sensor.frame(1, [hand_of(room.user, aim)])
        np.testing.assert_array_equal(empty.depth, with_hand.depth)


def test_a_low_camera_cuts_the_hand_at_the_images_edge():
    room = Room(camera_height_mm=380.0)
    sensor = Sensor(room, colour_times=0)
    hand = hand_of(room.user, FingerPose(132.0, 150.0, 5.0))
    px = sensor.camera.depth.project(sensor.surface.to_camera(hand.palm))
    assert px[0, 1] > sensor.camera.depth.height  # the wrist is out of the image
    tip = sensor.surface.to_camera(hand.pad(Finger.INDEX)[None])
    assert sensor.camera.depth.project(tip)[0, 1] < sensor.camera.depth.height - 60


def test_places_turn_with_the_seat_and_stay_on_the_table():
    here = from_seat(Room(), 225.0, 70.0)
    assert here == pytest.approx({"x_mm": 225.0, "y_mm": 70.0})
    assert from_seat(Room(seat_deg=180.0), 225.0, 70.0) == pytest.approx(
        {"x_mm": 75.0, "y_mm": 130.0}
    )
    for room in ROOMS:
        place = from_seat(room, 240.0, 110.0)
        assert 20.0 < place["x_mm"] < 280.0
        assert 20.0 < place["y_mm"] < 180.0


@pytest.mark.parametrize("scenario", ["threshold", "awkward", "typing", "ten-fingers", "chaos"])
@pytest.mark.parametrize("seed", [*range(213, 219), *range(313, 325)])
def test_every_fresh_user_touches_in_every_scenario(seed, scenario):
    """They draw; what the sensing makes of users from 313 on is for the report alone."""
    room = parse_sim_url(f"sim:{scenario}?seed={seed}&sensor=true").room
    running, touching = start_scenario(scenario, room), 0
    for t_s in np.arange(0.0, 8.0, 0.25):
        for hand in running.at(t_s).hands:
            touching += max(hand.force_g) > 0.0
            lowest = hand.vertices[np.abs(hand.vertices[:, 1] - 100.0) < 200.0, 2].max(initial=-1)
            assert lowest < 3.0
    assert touching
    assert scenario in SCENARIOS
