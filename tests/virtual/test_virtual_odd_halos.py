"""Halos that are no bell under the fingertip, on the field and on frames."""

import dataclasses

import numpy as np
import pytest

from halo_service.values import Finger, Side
from halo_service.virtual import halo
from halo_service.virtual.dents import dents_of, glows_of
from halo_service.virtual.halo import Dent, HaloCurve, dent_field, depth
from halo_service.virtual.hand import pointing
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.skeleton import FingerPose, posed

FULL = (1.0, 1.0, 1.0)
GRID = np.meshgrid(*[np.arange(-60.0, 61.0, dtype=np.float32)] * 2)
MIDDLE = FingerPose(150.0, 100.0, 0.0, 100.0, 45.0, 0.0)


def with_curve(**fields):
    return Room(noise=0.0, curve=HaloCurve(**fields))


def hand_at(room, aim=MIDDLE):
    return posed(room.user, pointing(room.user, Side.RIGHT, aim))


def tip_dent(room, aim=MIDDLE):
    """The dent of the index fingertip: the deepest one."""
    return max(dents_of(room, hand_at(room, aim), FULL), key=lambda dent: dent.depth_mm)


def width(field, axis):
    """Distance over which a field is at least half as deep as its deepest point, mm."""
    row = field[60] if axis == "x" else field[:, 60]
    return np.count_nonzero(row > field.max() / 2.0)


@pytest.mark.parametrize("yaw", [-30.0, 0.0, 40.0])
@pytest.mark.parametrize("shift", [1.0, 5.0])
def test_a_moved_halo_lies_towards_the_palm(shift, yaw):
    room = with_curve(shift_mm=shift)
    aim = dataclasses.replace(MIDDLE, yaw_deg=yaw)
    dent, hand = tip_dent(room, aim), hand_at(room, aim)
    moved = np.array([dent.x_mm, dent.y_mm]) - hand.pad(Finger.INDEX)[:2]
    towards_palm = (hand.joints[Finger.INDEX, 2] - hand.joints[Finger.INDEX, 3])[:2]
    assert np.linalg.norm(moved) == pytest.approx(shift)
    assert moved @ towards_palm > 0.99 * shift * np.linalg.norm(towards_palm)


@pytest.mark.parametrize("stretch", [1.2, 1.8])
def test_a_drawn_out_halo_is_longer_along_the_finger_only(stretch):
    ahead = dent_field([Dent(0, 0, 10.0, 11.0, (0.0, -1.0), stretch)], *GRID)
    aside = dent_field([Dent(0, 0, 10.0, 11.0, (1.0, 0.0), stretch)], *GRID)
    assert width(ahead, "y") / width(ahead, "x") == pytest.approx(stretch, abs=0.12)
    assert width(aside, "x") / width(aside, "y") == pytest.approx(stretch, abs=0.12)
    assert ahead.max() == pytest.approx(10.0, rel=1e-4)


def test_a_lopsided_halo_is_stronger_on_one_side():
    field = dent_field([Dent(0, 0, 10.0, 11.0, (0.0, -1.0), 1.0, 0.3)], *GRID)
    even = dent_field([Dent(0, 0, 10.0, 11.0)], *GRID)
    right, left = field[60, 72] / even[60, 72], field[60, 48] / even[60, 48]
    assert 1.15 < right < 1.3
    assert right + left == pytest.approx(2.0, abs=1e-3)
    assert field[48, 60] == pytest.approx(even[48, 60])


def test_the_footprint_widens_with_height_and_with_force():
    room = with_curve(wider_high=0.5, wider_pressed=0.35)
    touch = tip_dent(room, dataclasses.replace(MIDDLE, force_g=0.0)).radius_mm
    high = tip_dent(room, dataclasses.replace(MIDDLE, force_g=0.0, height_mm=10.0)).radius_mm
    pressed = tip_dent(room, dataclasses.replace(MIDDLE, force_g=halo.FIRM_G)).radius_mm
    assert touch == pytest.approx(halo.RADIUS_MM)
    assert high / touch == pytest.approx(1.25)
    assert pressed / touch == pytest.approx(1.35)


@pytest.mark.parametrize("corner", range(4))
def test_strength_falls_towards_one_corner_only(corner):
    curve = HaloCurve(corner_fall=0.45, corner=corner)
    plain = HaloCurve()
    places = [(x * 150.0, y * 100.0) for x, y in halo.CORNERS]
    left = [halo.by_place(curve, *at) / halo.by_place(plain, *at) for at in places]
    assert left[corner] == pytest.approx(0.55)
    assert left[corner - 2] == pytest.approx(1.0)
    assert left[corner - 1] == pytest.approx(left[corner - 3]) == pytest.approx(0.775)


@pytest.mark.parametrize("power", [0.5, 0.75, 1.0])
def test_a_press_is_a_power_of_the_force_or_levels_off(power):
    forces = np.array([25.0, 50.0, 100.0, 200.0, 385.0])
    straight = HaloCurve(press_power=power)
    saturating = HaloCurve(press_power=power, press_saturates=True)
    grown = np.array([straight.press(force) for force in forces])
    assert np.diff(np.log(grown)) / np.diff(np.log(forces)) == pytest.approx(np.full(4, power))
    assert grown[-1] == pytest.approx(1.0) == pytest.approx(saturating.press(385.0))
    assert saturating.press(200.0) > straight.press(200.0)
    assert straight.press(-1e-15) == 0.0  # what rounding leaves of a force that ends
    deep = [depth(saturating, 0.0, force) for force in forces]
    assert np.diff(deep).min() > 0.0


def test_a_glow_surrounds_a_low_hand_and_leaves_a_high_one():
    room = with_curve(glow_mm=2.0, glow_reach_mm=40.0)
    low, high = hand_at(room), hand_at(room, dataclasses.replace(MIDDLE, force_g=0, height_mm=95))
    assert len(glows_of(room, low, FULL)) > 5
    assert glows_of(room, high, FULL) == []
    assert glows_of(with_curve(), low, FULL) == []


@pytest.mark.parametrize("glow", [1.0, 2.0])
def test_a_glow_is_as_deep_as_it_says_on_frames(glow):
    """Mean over pixels 10 to 20 mm left of the thumb, where most of it is left."""
    readings = []
    for room in (with_curve(), with_curve(glow_mm=glow, glow_reach_mm=40.0)):
        sensor, hand = Sensor(room, colour_times=0), None
        hand = hand_at(room, dataclasses.replace(MIDDLE, pitch_deg=20.0))
        thumb = hand.joints[Finger.THUMB, 3] - (hand.radii[Finger.THUMB, 3], 0.0, 0.0)
        x, y = np.meshgrid(thumb[0] - np.linspace(10.0, 20.0, 12), thumb[1] + np.arange(-6.0, 6.0))
        places = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        px = np.rint(sensor.camera.depth.project(sensor.surface.to_camera(places))).astype(int)
        frames = [sensor.frame(t, [hand]).depth for t in range(1, 9)]
        readings.append(np.mean([frame[px[:, 1], px[:, 0]] for frame in frames]))
    assert 0.75 * glow < readings[1] - readings[0] < 1.05 * glow


def test_shape_is_bell_or_odd():
    assert HaloCurve(wider_high=0.4, corner_fall=0.3, press_power=0.6).shape == "bell"
    for field, value in (("shift_mm", 2.0), ("stretch", 1.4), ("lopsided", 0.2), ("glow_mm", 1.0)):
        assert HaloCurve(**{field: value}).shape == "odd"
