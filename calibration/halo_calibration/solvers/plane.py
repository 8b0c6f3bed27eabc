"""The plane of the surface, and the surface's frame from the camera's view alone. Pure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_calibration.errors import NO_HALO, CalibrationError
from halo_calibration.image_places import largest
from halo_calibration.solvers.plane_fit import least_squares, ransac
from halo_service.geometry.camera import Camera, Points
from halo_service.geometry.surface import Surface, from_view
from halo_service.profile import Background

STEP_PX = 4
"""Every fourth pixel in both directions: 20,000 points determine a plane well enough."""
REACH_MM = 8.0
"""How far from the plane a point may lie: the sensor's systematic error is a few mm."""
ROUNDS = 12
"""Of the reweighted fit: a thing 3 mm high needs ten, a clear table four."""
TUKEY = 4.685
"""Of a robust standard deviation; the usual choice for Tukey's weights."""
LEAST_SIGMA_MM = 0.3
"""Less noise than this the sensor never has."""
LEFT_OUT_MM = 8.0
"""Points farther from the plane are reported as left out: a cup, a book, the table's edge."""
REPORTED_SHARE = 0.005
"""Smaller things are not reported."""
LEAST_MEASURED = 0.5
"""Share of the surface's area where a depth must be measured."""
LEAST_ON_PLANE = 0.5
"""Share of the central area's points that must lie on the plane."""
STEEPEST_DEG = 50.0
"""Beyond this tilt a touch is below the paper's range (Appendix B)."""


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane in the depth camera's frame."""

    normal: tuple[float, float, float]
    """Unit, into the surface."""
    distance_mm: float
    """From the lens to the plane along the optical axis."""
    residual_mm: float
    """Root mean square distance of the points on it."""
    left_out: float
    """Share of all measured points that are not on it."""
    note: str
    """What was left out, in words; empty where it is not worth one."""

    @property
    def tilt_deg(self) -> float:
        """Angle between the optical axis and the normal."""
        return float(np.degrees(np.arccos(np.clip(self.normal[2], -1.0, 1.0))))


def solve_plane(background: Background, camera: Camera) -> Plane:
    """Fit the plane that lies around the optical axis.

    Raises `CalibrationError` where too little is measured there, or no plane is.
    """
    rows, columns = np.mgrid[: camera.depth.height : STEP_PX, : camera.depth.width : STEP_PX]
    valid = background.valid[::STEP_PX, ::STEP_PX]
    depth = background.mean_mm[::STEP_PX, ::STEP_PX].astype(np.float64)
    px = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
    points = camera.depth.rays(px) * depth.reshape(-1, 1)
    central = _central(camera, px)
    measured = valid.ravel()
    if np.count_nonzero(central & measured) < LEAST_MEASURED * np.count_nonzero(central):
        share = 100.0 * np.count_nonzero(central & measured) / np.count_nonzero(central)
        raise CalibrationError(
            f"only {share:.0f} % of the surface gives a depth at all; {NO_HALO}; or the camera is "
            f"covered or too far away: it should stand 45 to 70 cm above"
        )
    normal, offset = ransac(points[central & measured], REACH_MM)
    off = np.abs(points @ normal - offset)
    if np.count_nonzero(off[central & measured] < REACH_MM) < LEAST_ON_PLANE * np.count_nonzero(
        central & measured
    ):
        raise CalibrationError(
            "there is no flat surface in the middle of the camera's view: clear the table, or "
            "point the camera at it, and take the background again"
        )
    normal, offset = _refined(points[measured], normal, offset)
    tilt_deg = float(np.degrees(np.arccos(min(normal[2], 1.0))))
    if tilt_deg > STEEPEST_DEG:
        raise CalibrationError(
            f"the camera sees the surface at {tilt_deg:.0f} degrees from straight above, and the "
            f"halo fades beyond {STEEPEST_DEG:.0f}: let it look down more steeply"
        )
    off = points @ normal - offset
    on = measured & (np.abs(off) < LEFT_OUT_MM)
    return Plane(
        normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        distance_mm=float(offset / normal[2]),
        residual_mm=float(np.sqrt(np.mean(off[on] ** 2))),
        left_out=float(1.0 - np.count_nonzero(on) / np.count_nonzero(measured)),
        note=_note((measured & ~on).reshape(valid.shape), off.reshape(valid.shape)),
    )


def surface_from_view(plane: Plane, width_mm: float = 300.0, height_mm: float = 200.0) -> Surface:
    """Place the surface's frame around the optical axis; the picture's top is the far edge."""
    return from_view(
        np.array(plane.normal), plane.distance_mm, width_mm=width_mm, height_mm=height_mm
    )


def _central(camera: Camera, px: Points) -> NDArray[np.bool_]:
    """Say which pixels look at about the surface's 300 x 200 mm: a third of the picture around
    the optical axis, which at 0.5 m is 210 px to each side."""
    x = np.abs(px[:, 0] - camera.depth.cx) < camera.depth.width / 4.0
    y = np.abs(px[:, 1] - camera.depth.cy) < camera.depth.height / 5.0
    return np.asarray(x & y)


def _refined(points: Points, normal: Points, offset: float) -> tuple[Points, float]:
    """Fit (N, 3) points near a plane by least squares with Tukey's weights.

    RANSAC alone counts points within `REACH_MM`, so a book 10 mm high tilts its plane by 0.4
    degrees; the weights leave the book out.
    """
    for _ in range(ROUNDS):
        off = points @ normal - offset
        near = np.abs(off) < 3.0 * REACH_MM
        sigma = max(1.4826 * float(np.median(np.abs(off[near]))), LEAST_SIGMA_MM)
        share = np.minimum(np.abs(off) / (TUKEY * sigma), 1.0)
        normal, offset = least_squares(points, (1.0 - share**2) ** 2)
    return normal, offset


def _note(left: NDArray[np.bool_], off_mm: Points) -> str:
    size, place = largest(left)
    if size < REPORTED_SHARE * left.size:
        return ""
    height = float(np.median(np.abs(off_mm[left])))
    side = "above" if float(np.median(off_mm[left])) < 0.0 else "below"
    return f"something {place} lies about {height:.0f} mm {side} the plane and was left out"
