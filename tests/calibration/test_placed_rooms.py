"""Surface, projector and anchor in rooms with a known truth: one table, one line of figures each.

`pytest -n0 -s` prints them. A new room is a new line.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest

from halo_calibration.boards.board import SHEET, Projected, anchor
from halo_calibration.solvers.projector import projector_by_markers
from halo_calibration.solvers.surface import SurfaceFit, surface_by_markers
from halo_service.virtual.props import printed
from tests.placed import (
    Distortion,
    Place,
    anchored,
    grid,
    hung,
    off_px,
    pose_error,
    posed,
    room,
    sent,
    turned,
)


class Where(NamedTuple):
    """One room, and the camera and the projector in it."""

    height_mm: float
    pitch_deg: float
    yaw_deg: float
    keystone_deg: float
    lens: str
    material: str
    light: float
    """Of a well-lit office; the board is seen at a third of it."""
    noise: float
    """Times the sensor's own."""
    resolution: str
    projector_px: tuple[int, int]


ROOMS = [
    #     height  pitch   yaw  keystone  lens      material  light noise  camera    projector
    Where(450.0, 0.0, 0.0, 10.0, "factory", "paper", 1.0, 1.0, "720P", (1280, 800)),
    Where(500.0, 15.0, 0.0, 30.0, "factory", "wood", 0.8, 2.0, "720P", (1280, 800)),
    Where(550.0, 0.0, -15.0, 25.0, "barrel", "wood", 0.7, 1.0, "1080P", (1280, 720)),
    Where(620.0, -8.0, 12.0, 20.0, "factory", "suede", 0.6, 1.0, "1080P", (1280, 720)),
    Where(700.0, 10.0, -10.0, 30.0, "cushion", "foam", 1.0, 2.0, "1536P", (1920, 1080)),
    Where(1000.0, -15.0, 0.0, 30.0, "factory", "plastic", 0.7, 1.0, "720P", (1280, 800)),
    Where(1000.0, 15.0, 0.0, 30.0, "barrel", "paper", 0.5, 2.0, "1536P", (1280, 800)),
]
LENSES: dict[str, Distortion | None] = {
    "factory": None,
    "barrel": (-0.06, 0.0, 4e-4, -3e-4, 0.0, 0.0, 0.0, 0.0),
    "cushion": (0.05, 0.0, -3e-4, 4e-4, 0.0, 0.0, 0.0, 0.0),
}
"""Of the colour camera: its own, and two that bend the picture's corners by 5 to 9 %."""
SHEET_AT = 160.0, 95.0, 8.0
SIZE = 280.0, 180.0
PAPER_MM = 297.0, 210.0
PAPER = SHEET.picture(*PAPER_MM, 4)
TAG = anchor("apriltag-36h11", 0, 80.0)
LYING, LEANING = posed(190.0, 120.0, 0.0, -35.0), posed(110.0, 110.0, -50.0, 70.0, 20.0, -10.0)


@pytest.fixture(scope="module", params=ROOMS, ids=lambda r: f"{r.height_mm:.0f} mm, {r.material}")
def where(request) -> Where:
    return request.param


@pytest.fixture(scope="module")
def place(where: Where) -> Place:
    table = room(
        where.height_mm,
        where.pitch_deg,
        where.yaw_deg,
        material=where.material,
        light=where.light,
        noise=where.noise,
        projector=hung(where.keystone_deg, *where.projector_px),
    )
    return Place(table, where.resolution, LENSES[where.lens])


def off_mm(place: Place, fit: SurfaceFit) -> np.ndarray:
    """(25,) how far from the truth a touch would be reported."""
    x, y, turn_deg = SHEET_AT
    places = grid(*SIZE)
    truth = sent(turned(x, y, turn_deg) @ turned(-SIZE[0] / 2.0, -SIZE[1] / 2.0, 0.0), places)
    return np.linalg.norm(place.read_at(fit.surface, truth) - places, axis=1)


@pytest.mark.parametrize("seen_in", ["colour", "infrared"])
def test_the_sheet_gives_the_surface(where: Where, place: Place, seen_in: str) -> None:
    sheet = printed(PAPER, *SHEET_AT[:2], PAPER_MM[0], SHEET_AT[2])
    furnished = dataclasses.replace(place.room, sheets=(sheet,))
    camera = place.camera
    if seen_in == "colour":
        view = place.colour(room=furnished), camera.colour, camera.colour_from_depth
    else:
        view = place.infrared(furnished), camera.depth, np.eye(4)
    fit = surface_by_markers(*view, place.plane, *SIZE)
    off = off_mm(place, fit)
    print(f"{name_of(where)} surface in {seen_in} {off.mean():.2f} mm, at most {off.max():.2f}")
    assert off.max() < 1.5
    assert fit.error_mm < 1.0
    assert fit.error_px < 1.0
    assert (fit.surface.width_mm, fit.surface.height_mm) == SIZE


def test_the_projected_board_gives_the_homography(where: Where, place: Place) -> None:
    camera, board = place.camera, Projected(*where.projector_px)
    dimmed = dataclasses.replace(place.room, light=where.light / 3.0, exposure_ms=6.0)
    picture = place.colour(board.picture(), room=dimmed)
    solved = projector_by_markers(
        picture, board, camera.colour, camera.colour_from_depth, place.plane
    )
    off = off_px(place, solved)
    print(f"{name_of(where)} homography {off.mean():.2f} px, at most {off.max():.2f}")
    assert off.mean() < 1.5
    assert solved.error_px < 1.5
    assert solved.covered > 0.9
    assert solved.projector.projector_from_surface[2, 2] == 1.0
    assert (solved.projector.width_px, solved.projector.height_px) == where.projector_px


@pytest.mark.parametrize("there", [LYING, LEANING], ids=["lying", "leaning"])
def test_the_marker_gives_the_anchor(where: Where, place: Place, there: np.ndarray) -> None:
    off, off_deg = pose_error(anchored(place, TAG, there), there)
    print(f"{name_of(where)} anchor {off:.2f} mm, {off_deg:.2f} degrees")
    assert off < 2.0
    assert off_deg < 0.5


def name_of(where: Where) -> str:
    """Name a room in the figures that are printed."""
    return (
        f"{where.height_mm:4.0f} mm, tilt {where.pitch_deg:3.0f} and {where.yaw_deg:3.0f}, "
        f"keystone {where.keystone_deg:2.0f}, {where.lens:7}, {where.material:7}, "
        f"light {where.light:.1f}, noise {where.noise:.0f}, {where.resolution:5}:"
    )
