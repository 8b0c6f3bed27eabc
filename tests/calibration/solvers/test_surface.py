"""The surface's frame lies where the sheet lies, or where the corners were touched."""

import numpy as np
import pytest

from halo_calibration.boards.board import SHEET
from halo_calibration.solvers.surface import CORNERS, surface_by_markers, surface_by_touches
from halo_calibration.steps import Setup, surface_change
from halo_service.geometry.surface import Surface
from halo_service.virtual.props import printed
from tests.placed import Place, grid, refusal, room, sent, turned

A4 = 297.0, 210.0
PAPER = SHEET.picture(*A4, 4)
PLANE = Surface("table", 300.0, 200.0, np.eye(4))
RECTANGLE = np.array([[0.0, 0.0], [310.0, 0.0], [310.0, 190.0], [0.0, 190.0]])


def touched(turn_deg, noise_mm, seed=1, order=(0, 1, 2, 3), count=3):
    """Touches of a rectangle that lies on the plane, turned; with noise."""
    rng = np.random.default_rng(seed)
    corners = sent(turned(40.0, 25.0, turn_deg), RECTANGLE)[list(order)]
    return [corner + rng.normal(0.0, noise_mm, (count, 2)) for corner in corners]


@pytest.mark.parametrize("turn_deg", [0.0, 7.0, 90.0, -135.0, 180.0])
def test_four_touched_corners_give_the_surface(turn_deg):
    off = []
    for seed in range(20):
        fitted = surface_by_touches(touched(turn_deg, 2.0, seed), PLANE)
        there = sent(turned(40.0, 25.0, turn_deg), grid(310.0, 190.0))
        here = fitted.surface.from_camera(np.column_stack([there, np.zeros(25)]))[:, :2]
        off.append(np.linalg.norm(here - grid(310.0, 190.0), axis=1))
    print(f"turned by {turn_deg:.0f}: {np.mean(off):.2f} mm, at most {np.max(off):.2f}")
    assert np.mean(off) < 1.5
    assert np.max(off) < 4.0


def test_touches_without_an_error_give_the_rectangle_itself():
    fitted = surface_by_touches(touched(30.0, 0.0), PLANE)
    assert fitted.surface.width_mm == pytest.approx(310.0)
    assert fitted.surface.height_mm == pytest.approx(190.0)
    np.testing.assert_allclose(fitted.surface.camera_from_surface[:2, 3], [40.0, 25.0], atol=1e-9)
    assert fitted.error_mm == pytest.approx(0.0, abs=1e-9)
    assert fitted.surface.name == "table"


def moved(corner, by):
    touches = touched(0.0, 0.5)
    touches[corner] = touches[corner] + by
    return touches


def strayed():
    touches = touched(0.0, 0.5)
    touches[2][1] += (0.0, 15.0)
    return touches


@pytest.mark.parametrize(
    ("touches", "why"),
    [
        (touched(0.0, 0.5, order=(1, 0, 3, 2)), "in another order: touch far left, far right"),
        (touched(0.0, 0.5, order=(0, 3, 2, 1)), "in another order"),
        (touched(0.0, 0.5, order=(0, 2, 1, 3)), "in another order|no rectangle"),
        (moved(1, (40.0, 0.0)), "no rectangle .the (far|near) (left|right) one is off by"),
        (strayed(), "near right corner lie up to 1[0-9] mm apart: touch it again"),
        (touched(0.0, 0.5, count=2), "far left corner was touched 2 times: touch it 3"),
        ([touch * 0.1 for touch in touched(0.0, 0.5)], "31 x 19 mm cannot be used"),
    ],
    ids=["mirrored", "turned round", "crossed", "a corner off", "one strays", "too few", "tiny"],
)
def test_touches_that_make_no_surface_are_refused(touches, why):
    with pytest.raises(Exception, match=why):
        surface_by_touches(touches, PLANE)


def test_the_corners_are_named_in_the_order_of_the_touches():
    assert CORNERS == ("far left", "far right", "near right", "near left")


@pytest.mark.parametrize(
    ("paper_mm", "says"),
    [(0.94, "93.[0-9] %"), (0.97, "96.[0-9] %"), (1.04, "103.[0-9] %")],
)
def test_a_sheet_of_another_size_is_refused(paper_mm, says):
    place = Place(room(sheets=(printed(PAPER, 150.0, 100.0, A4[0] * paper_mm),)))
    camera = place.camera
    with pytest.raises(Exception, match=f"measure {says} of their true size: print it at 100 %"):
        surface_by_markers(place.colour(), camera.colour, camera.colour_from_depth, place.plane)


@pytest.mark.parametrize("size", [(10.0, 200.0), (300.0, -5.0), (float("nan"), 200.0)])
def test_a_surface_of_no_size_is_refused(size):
    place = Place(room(sheets=(printed(PAPER, 150.0, 100.0, A4[0]),)))
    camera = place.camera
    view = place.colour(), camera.colour, camera.colour_from_depth
    setup = Setup("desk", camera, "2026-01-01T00:00:00Z")
    for call in (
        lambda: surface_by_markers(*view, place.plane, *size),
        lambda: surface_change(setup, *size),
    ):
        assert f"{size[0]:.0f} x {size[1]:.0f} mm cannot be used" in refusal(call)
