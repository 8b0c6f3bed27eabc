"""The user's frame on the plane: from a printed sheet, or from four touched corners. Pure.

Rule: the plane is known (the background's), so all that is sought is a turn and a shift on it.
Up is the sheet's upper edge, or the edge between the two corners touched first: the far edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from halo_calibration.boards.board import SHEET, Picture
from halo_calibration.boards.detect import DetectedBoard, detect
from halo_calibration.boards.hints import require_seen
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.rigid2d import fit_rigid, steady
from halo_service.geometry.camera import Lens, Points
from halo_service.geometry.surface import Surface

PRINT_ERROR = 0.02
"""Printers err by less than 0.5 %, the camera's distance by less than 1.5 %; 'fit to page' makes
A4 3 % smaller and more."""
FLAT_MM = 1.5
"""Root mean square of a sheet that lies flat is below 0.5 mm at 1 m."""
CORNERS = ("far left", "far right", "near right", "near left")
"""In the order in which they are touched."""
SQUARE_MM = 8.0
"""How far a touched corner may lie from the rectangle through all four: with 4 mm wanted, more
is no touch's error but another corner's."""
SIZE_MM = (60.0, 2000.0)
"""Sides that a surface can have: a hand's width, and what the camera sees from 1 m."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceFit:
    """A surface, and how well what was seen agrees with it."""

    surface: Surface
    error_mm: float
    """Root mean square over the points."""
    error_px: float
    """The same in the camera's picture; nan for touches."""
    off_mm: Points
    """(N,) of each point: the corners of the markers seen, or the four corners."""
    scale: float
    """Measured over printed size; 1 for touches."""


def surface_by_markers(
    picture: Picture,
    lens: Lens,
    lens_from_camera: Points,
    plane: Surface,
    width_mm: float = 300.0,
    height_mm: float = 200.0,
) -> SurfaceFit:
    """Lay a surface of a size around the middle of the printed sheet.

    `picture`: (h, w) or (h, w, 3) uint8 through `lens`; `lens_from_camera`: (4, 4) mm from the
    depth camera's frame; `plane`: any surface on the plane. Raises `CalibrationError`.
    """
    seen = detect(picture, SHEET)
    require_seen(seen, picture, SHEET)
    return surface_of(seen, lens, lens_from_camera, plane, width_mm, height_mm)


def surface_of(
    seen: DetectedBoard,
    lens: Lens,
    lens_from_camera: Points,
    plane: Surface,
    width_mm: float,
    height_mm: float,
) -> SurfaceFit:
    """Lay a surface around the middle of a sheet that was seen. Raises `CalibrationError`."""
    check_size(width_mm, height_mm)
    places = plane.seen_at(seen.picture, lens, lens_from_camera)
    rigid = fit_rigid(seen.board, places)
    if abs(rigid.scale - 1.0) > PRINT_ERROR:
        raise CalibrationError(
            f"the sheet's markers measure {100.0 * rigid.scale:.1f} % of their true size: print it "
            f"at 100 %, not 'fit to page', check the ruler on it, and lay it flat on the table "
            f"itself"
        )
    corner = np.eye(3)
    corner[:2, 2] = (-width_mm / 2.0, -height_mm / 2.0)
    surface = plane.moved(rigid.there_from_here @ corner, width_mm, height_mm)
    error_mm = _rms(rigid.off_mm)
    if error_mm > FLAT_MM:
        raise CalibrationError(
            f"the sheet does not lie flat (its markers are off by {error_mm:.1f} mm): smooth it, "
            f"fix its corners with tape, and try again"
        )
    sheet = seen.board - corner[:2, 2]
    off_px = surface.in_picture(sheet, lens, lens_from_camera) - seen.picture
    error_px = _rms(np.linalg.norm(off_px, axis=1))
    return SurfaceFit(surface, error_mm, error_px, rigid.off_mm, rigid.scale)


def surface_by_touches(touches: Sequence[Points], plane: Surface) -> SurfaceFit:
    """Return the rectangle with the touched corners: far left, far right, near right, near left.

    `touches`: four times (N, 2) mm in the frame of `plane`, three touches or more each.
    Raises `CalibrationError` where they differ, are in another order, or are no rectangle.
    """
    middles = np.array(
        [steady(f"the {name} corner", at) for name, at in zip(CORNERS, touches, strict=True)]
    )
    complex_middles = middles @ (1.0, 1j)
    far_left, far_right, near_right, near_left = complex_middles
    across = ((far_right + near_right) - (far_left + near_left)) / 2.0
    # A quarter turn back, so that a rectangle's sides point the same way.
    down = ((near_left + near_right) - (far_left + far_right)) / 2.0 * -1j
    if (across * np.conj(down)).real <= 0.0:
        raise CalibrationError(
            f"the corners were touched in another order: touch {', '.join(CORNERS)}, as you sit"
        )
    turn = np.sqrt(across**2 + down**2)
    turn *= 1.0 if (turn * np.conj(across)).real > 0.0 else -1.0
    turn /= abs(turn)
    width_mm, height_mm = float((across / turn).real), float((down / turn).real)
    check_size(width_mm, height_mm)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * (width_mm, height_mm)
    rigid = fit_rigid(square, middles)
    worst = int(np.argmax(rigid.off_mm))
    if rigid.off_mm[worst] > SQUARE_MM:
        raise CalibrationError(
            f"the four corners are no rectangle (the {CORNERS[worst]} one is off by "
            f"{rigid.off_mm[worst]:.0f} mm): touch them again, each at the same mark"
        )
    surface = plane.moved(rigid.there_from_here, width_mm, height_mm)
    return SurfaceFit(surface, _rms(rigid.off_mm), float("nan"), rigid.off_mm, 1.0)


def check_size(width_mm: float, height_mm: float) -> None:
    """Raise `CalibrationError` for a surface that is none."""
    low, high = SIZE_MM
    if not all(low <= size <= high for size in (width_mm, height_mm)):
        raise CalibrationError(
            f"a surface of {width_mm:.0f} x {height_mm:.0f} mm cannot be used: its sides may be "
            f"{low:.0f} to {high:.0f} mm long"
        )


def _rms(off: Points) -> float:
    return float(np.sqrt(np.mean(off**2)))
