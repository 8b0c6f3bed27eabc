"""The pose of a printed marker, for whoever else sees it. Pure.

Rule: four corners give a marker's rotation and place well, its tilt and distance badly. So those
come from a plane: the surface's own where the marker lies on it, else the one that its depth
shows. Depth is taken where the marker is white, for what is dark reads at another distance; and
the device's own unevenness, which the background shows at the same pixels, is taken off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.boards.board import SQUARE, Picture, Printed, marker_squares
from halo_calibration.boards.detect import detect
from halo_calibration.boards.hints import require_seen
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.background import average
from halo_calibration.solvers.rigid2d import Rigid, fit_rigid
from halo_service.geometry.camera import Camera, Points
from halo_service.geometry.surface import Surface
from halo_service.profile import Anchor, Background
from halo_service.values import Depth

LIES_MM, LIES_DEG = 1.5, 1.5
"""A marker that is no higher and no more tilted lies on the surface: a sheet of paper does."""
SIZE_ERROR = 0.03
"""Measured over given size; a printer's error and the camera's together stay below 2 %."""
FLAT_MM = 1.5
"""Its corners lie on a square, root mean square."""
INNER = 0.7
"""Of each white square where its depth is taken: edges are mixed with what is dark or behind."""
LEAST_PX = 150
"""Depth pixels on the marker's white, enough for a plane's tilt to half a degree."""
LEAST_MEASURED = 0.5
"""Of these."""
ROUNDS = 3
"""A raised marker lies elsewhere in the depth picture than a flat one would; it settles at once."""
TRIM = 3.0
"""Robust standard deviations beyond which a depth is left out."""


@dataclass(frozen=True, slots=True, eq=False)
class Anchored:
    """A marker's pose, and how well what was seen agrees with it."""

    anchor: Anchor
    error_mm: float
    """Root mean square of its corners."""
    scale: float
    """Measured over given size."""
    height_mm: float
    """Of its middle above the surface, by depth."""
    tilt_deg: float
    """Against the surface, by depth."""
    lies: bool
    """It lies on the surface, and was taken to do so exactly."""


def anchor_pose(
    picture: Picture,
    marker: Printed,
    camera: Camera,
    surface: Surface,
    background: Background,
    depths: Sequence[Depth],
) -> Anchored:
    """Find where a single marker is.

    `picture`: (h, w) or (h, w, 3) uint8 of the colour lens; `depths`: (H, W) uint16 mm of the
    same time, one or better thirty; `background`: of the same camera without the marker.
    Raises `CalibrationError`; ValueError for a camera without colour.
    """
    if camera.colour is None:
        raise ValueError("the camera has no colour lens")
    seen = detect(picture, marker)
    require_seen(seen, picture, marker)
    lens, lens_from_camera = camera.colour, camera.colour_from_depth
    depth = _Depth(average(depths), background, surface, camera)
    plane, slopes = surface, np.zeros(3)
    white = _white(marker)
    for _ in range(ROUNDS):
        rigid = fit_rigid(seen.board, plane.seen_at(seen.picture, lens, lens_from_camera))
        slopes = depth.plane_on(_placed(rigid, white, plane))
        plane = _plane(surface, slopes)
    middle = surface.from_camera(_placed(rigid, np.zeros((1, 2)), plane))[0]
    height_mm = -float(slopes @ (middle[0], middle[1], 1.0))
    tilt_deg = float(np.degrees(np.arctan(np.hypot(slopes[0], slopes[1]))))
    lies = abs(height_mm) < LIES_MM and tilt_deg < LIES_DEG
    plane = surface if lies else plane
    rigid = fit_rigid(seen.board, plane.seen_at(seen.picture, lens, lens_from_camera))
    error_mm = float(np.sqrt(np.mean(rigid.off_mm**2)))
    _require_true(rigid.scale, error_mm, marker)
    return Anchored(
        Anchor(marker.family.name, seen.numbers[0], marker.size_mm, _pose(rigid, plane, surface)),
        error_mm,
        rigid.scale,
        height_mm,
        tilt_deg,
        lies,
    )


def _require_true(scale: float, error_mm: float, marker: Printed) -> None:
    if abs(scale - 1.0) > SIZE_ERROR:
        raise CalibrationError(
            f"the {marker.name} measures {scale * marker.size_mm:.1f} mm and not the "
            f"{marker.size_mm:g} mm given: give the size of its black square, or print it at "
            f"100 %, and try again"
        )
    if error_mm > FLAT_MM:
        raise CalibrationError(
            f"the {marker.name} is no square (its corners are off by {error_mm:.1f} mm): fix it "
            f"on something flat, and try again"
        )


def _pose(rigid: Rigid, plane: Surface, surface: Surface) -> Points:
    """(4, 4) anchor_from_surface, mm."""
    plane_from_anchor = np.eye(4)
    plane_from_anchor[:2, :2] = rigid.there_from_here[:2, :2]
    plane_from_anchor[:2, 3] = rigid.there_from_here[:2, 2]
    camera_from_anchor = plane.camera_from_surface @ plane_from_anchor
    return np.asarray(
        np.linalg.inv(camera_from_anchor) @ surface.camera_from_surface, dtype=np.float64
    )


def _white(marker: Printed) -> Points:
    """(K * 4, 2) mm, the corners of what is certainly white: light squares and those around it."""
    (number,) = marker.middles_mm
    black = np.pad(marker_squares(marker.family, number), 1)
    rows, columns = np.nonzero(~black)
    middle = (np.column_stack([columns, rows]) - (len(black) - 1) / 2.0)[:, None]
    side = marker.size_mm / marker.family.modules
    return np.asarray(((middle + INNER * SQUARE) * side).reshape(-1, 2), dtype=np.float64)


def _placed(rigid: Rigid, places: Points, plane: Surface) -> Points:
    """(N, 3) mm in the depth camera's frame of (N, 2) mm on the marker."""
    there = places @ rigid.there_from_here[:2, :2].T + rigid.there_from_here[:2, 2]
    return plane.to_camera(np.column_stack([there, np.zeros(len(there))]))


def _plane(surface: Surface, slopes: Points) -> Surface:
    """Return the plane z = a x + b y + c of a surface's frame, with a frame of its own."""
    a, b, c = slopes
    x, normal = np.array([1.0, 0.0, a]), np.array([-a, -b, 1.0])
    x, normal = x / np.linalg.norm(x), normal / np.linalg.norm(normal)
    surface_from_plane = np.eye(4)
    surface_from_plane[:3, :3] = np.column_stack([x, np.cross(normal, x), normal])
    surface_from_plane[2, 3] = c
    matrix = surface.camera_from_surface @ surface_from_plane
    return Surface(surface.name, surface.width_mm, surface.height_mm, matrix)


class _Depth:
    """What the depth camera measures now, without the unevenness of its own."""

    def __init__(
        self, now: Background, before: Background, surface: Surface, camera: Camera
    ) -> None:
        both = now.valid & before.valid
        self._both = both
        change = now.mean_mm - before.mean_mm
        # Warming up, the device moves all of its picture alike.
        self._change = change - np.float32(np.median(change[both]) if both.any() else 0.0)
        self._surface = surface
        self._camera = camera

    def plane_on(self, corners: Points) -> Points:
        """(3,) a, b, c of the plane z = a x + b y + c, in the surface's frame, through squares.

        `corners`: (K * 4, 3) mm of the squares, in the depth camera's frame.
        Raises `CalibrationError`.
        """
        lens = self._camera.depth
        mask = np.zeros((lens.height, lens.width), np.uint8)
        for square in lens.project(corners).reshape(-1, 4, 2):
            cv2.fillConvexPoly(mask, np.round(square).astype(np.int32), (1,))
        on = mask.astype(np.bool_)
        measured = on & self._both
        every, count = int(np.count_nonzero(on)), int(np.count_nonzero(measured))
        if count < LEAST_PX or count < LEAST_MEASURED * every:
            raise CalibrationError(
                "the camera measures no depth on the marker: put it nearer to the surface's "
                "middle, or print a larger one on paper that is not glossy, and try again"
            )
        rows, columns = np.nonzero(measured)
        return _fitted(self._points(rows, columns))

    def _points(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Points:
        """(N, 3) mm in the surface's frame."""
        rays = self._camera.depth.rays(np.column_stack([columns, rows]).astype(np.float64))
        pose = self._surface.camera_from_surface
        bare = (pose[:3, 2] @ pose[:3, 3]) / (rays @ pose[:3, 2])
        return self._surface.from_camera(rays * (bare + self._change[rows, columns])[:, None])


def _fitted(points: Points) -> Points:
    """(3,) the plane through most points, by least squares."""
    good = np.ones(len(points), dtype=np.bool_)
    slopes = np.zeros(3)
    for _ in range(ROUNDS):
        known = np.column_stack([points[good, :2], np.ones(np.count_nonzero(good))])
        slopes = np.linalg.lstsq(known, points[good, 2], rcond=None)[0]
        off = np.abs(np.column_stack([points[:, :2], np.ones(len(points))]) @ slopes - points[:, 2])
        good = off < TRIM * max(1.4826 * float(np.median(off)), 0.2)
    return np.asarray(slopes, dtype=np.float64)
