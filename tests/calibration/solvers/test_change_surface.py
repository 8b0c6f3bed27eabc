"""A new surface on the same plane gets what was learnt over the old one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halo_calibration.solvers.change_surface import moved_to
from halo_service.geometry.surface import Surface
from halo_service.profile import Anchor, Profile, Projector

TURN_DEG, SHIFT_MM = 20.0, (30.0, -15.0)


@pytest.fixture(scope="module")
def turned(profile: Profile) -> Surface:
    """Turned clockwise as the user sees it, and shifted, in the old frame."""
    turn = np.radians(TURN_DEG)
    old_from_new = np.eye(4)
    old_from_new[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    old_from_new[:2, 3] = SHIFT_MM
    return Surface("table", 240.0, 160.0, profile.surface.camera_from_surface @ old_from_new)


@pytest.fixture(scope="module")
def placed(profile: Profile) -> Profile:
    anchor_from_surface = np.eye(4)
    anchor_from_surface[:3, 3] = (-40.0, -60.0, 10.0)
    matrix = np.array([[4.0, 0.4, 20.0], [0.1, 3.6, 30.0], [0.0002, 0.0006, 1.0]])
    return replace(
        profile,
        projector=Projector(1280, 800, matrix),
        anchor=Anchor("apriltag-36h11", 0, 80.0, anchor_from_surface),
    )


def moved(surface: Surface, other: Surface, point: tuple[float, float, float]) -> np.ndarray:
    """A point of `surface`'s frame in the other's."""
    return other.from_camera(surface.to_camera(np.array([point])))[0]


def test_projector_and_anchor_keep_where_they_are_on_the_table(
    placed: Profile, turned: Surface
) -> None:
    after = moved_to(placed, turned, None)
    assert after.surface is turned
    point = (120.0, 70.0, 0.0)
    there = moved(placed.surface, turned, point)

    def pixel(profile: Profile, at: np.ndarray) -> np.ndarray:
        image = profile.projector.projector_from_surface @ (at[0], at[1], 1.0)
        return image[:2] / image[2]

    assert pixel(after, there) == pytest.approx(pixel(placed, np.array(point)))
    assert after.projector.projector_from_surface[2, 2] == 1.0

    in_anchor = placed.anchor.anchor_from_surface @ (*point, 1.0)
    assert after.anchor.anchor_from_surface @ (*there, 1.0) == pytest.approx(in_anchor)


def test_held_states_keep_their_place_and_direction(placed: Profile, turned: Surface) -> None:
    touch = replace(placed.touch.touch, x_mm=100.0, y_mm=80.0, yaw_deg=10.0)
    before = replace(placed, touch=replace(placed.touch, touch=touch))
    after = moved_to(before, turned, None).touch.touch
    x, y, _ = moved(placed.surface, turned, (100.0, 80.0, 0.0))
    assert (after.x_mm, after.y_mm) == pytest.approx((x, y))
    # The surface was turned clockwise, so the finger now points so much less clockwise.
    assert after.yaw_deg == pytest.approx(10.0 - TURN_DEG)


def test_a_correction_says_the_same_of_the_same_finger(placed: Profile, turned: Surface) -> None:
    from halo_calibration.solvers.correction import Reference, solve_correction
    from halo_service.sensing.correction import higher, leveled, strength

    rng = np.random.default_rng(1)
    x, y, yaw = rng.uniform(0, 300, 600), rng.uniform(0, 200, 600), rng.uniform(-20, 20, 600)
    signal = 2000.0 * (1.0 + 0.002 * (x - 150.0))
    samples = np.column_stack(
        [x, y, np.full(600, 45.0), yaw, *(signal / n for n in (1, 100, 150, 400)), 0.05 * x]
    )
    at = Reference(0.0, 0.0, 45.0, 0.0)
    before = replace(placed, correction=solve_correction(placed.surface, None, samples, at))
    after = moved_to(before, turned, None)
    held = (0.0, 0.0, 45.0, 0.0)
    middle = (150.0, 100.0)
    new_middle = moved(placed.surface, turned, (*middle, 0.0))[:2]
    new_held = moved(placed.surface, turned, (0.0, 0.0, 0.0))[:2]
    for place in ((80.0, 60.0), (180.0, 120.0), (150.0, 40.0)):
        there = moved(placed.surface, turned, (*place, 0.0))[:2]
        old = strength(before.correction, *place, 45.0, 0.0) / strength(before.correction, *held)
        new = strength(after.correction, *there, 45.0, -TURN_DEG) / strength(
            after.correction, *new_held, 45.0, -TURN_DEG
        )
        assert new == pytest.approx(old, rel=0.08)
        old_deep = leveled([1.0] * 4, before.correction, *place)[0][1]
        old_deep /= leveled([1.0] * 4, before.correction, *middle)[0][1]
        new_deep = leveled([1.0] * 4, after.correction, *there)[0][1]
        new_deep /= leveled([1.0] * 4, after.correction, *new_middle)[0][1]
        assert new_deep == pytest.approx(old_deep, rel=0.01)
        old_top = higher(before.correction, *place)[0] - higher(before.correction, *middle)[0]
        new_top = higher(after.correction, *there)[0] - higher(after.correction, *new_middle)[0]
        assert new_top == pytest.approx(old_top, abs=0.3)
        assert abs(old_top) > 1.0 or place[0] == middle[0]


def test_every_held_state_moves_along_with_its_place(placed: Profile, turned: Surface) -> None:
    assert placed.touch is not None
    held = replace(placed, touch=replace(placed.touch, hard=placed.touch.pressure))
    after = moved_to(held, turned, None).touch
    assert after is not None and after.hard is not None
    assert (after.hard.x_mm, after.hard.y_mm) == (after.pressure.x_mm, after.pressure.y_mm)
    assert after.hard.x_mm != placed.touch.pressure.x_mm
