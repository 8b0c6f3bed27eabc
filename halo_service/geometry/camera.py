"""A depth camera's factory calibration: two lenses and the pose between them.

Rule: pixels have (0, 0) at the *centre* of the top left pixel, points are in mm,
x right, y down, z away. Matrices say their spaces: `colour_from_depth`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.matrix import Matrix4

Points = NDArray[np.float64]

UNDISTORTED_PX = 1.0
"""A ray is right if it projects to within this of its pixel."""
UNTURNED = np.eye(3)
FEW = 200
"""Up to so many points OpenCV projects faster than NumPy; beyond, its derivatives cost most."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A pinhole with the rational distortion of the Azure Kinect (OpenCV's 8-coefficient model)."""

    width: int
    """Image width, px."""
    height: int
    """Image height, px."""
    fx: float
    fy: float
    cx: float
    cy: float
    """Focal lengths and principal point, px."""
    distortion: tuple[float, float, float, float, float, float, float, float] = (0.0,) * 8
    """k1, k2, p1, p2, k3, k4, k5, k6, in OpenCV's order."""

    @property
    def matrix(self) -> Points:
        """(3, 3) camera matrix, px."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, points: Points) -> Points:
        """Map (N, 3) points in this lens's frame to (N, 2) pixels."""
        if len(points) == 0:
            return np.empty((0, 2))
        if len(points) > FEW:
            x, y, z = points.astype(np.float64).T
            away = 1.0 / np.where(z == 0.0, 1.0, z)
            with np.errstate(all="ignore"):  # what is far off the lens overflows, as in OpenCV
                return np.column_stack(self.distorted(x * away, y * away))
        zero = np.zeros(3)
        px, _ = cv2.projectPoints(points.astype(np.float64), zero, zero, *_for_opencv(self))
        return np.asarray(px, dtype=np.float64).reshape(-1, 2)

    def distorted(self, x: Points, y: Points) -> tuple[Points, Points]:
        """Map (N,) x and y of directions with z = 1 to (N,) columns and rows, px.

        The same numbers as OpenCV's, bit for bit on x86-64.
        """
        k1, k2, p1, p2, k3, k4, k5, k6 = self.distortion
        r2 = x * x + y * y
        r4 = r2 * r2
        r6 = r4 * r2
        radial = 1.0 + k1 * r2 + k2 * r4 + k3 * r6
        less = 1.0 / (1.0 + k4 * r2 + k5 * r4 + k6 * r6)
        twice = 2.0 * x * y
        column = x * radial * less + p1 * twice + p2 * (r2 + 2.0 * x * x)
        row = y * radial * less + p1 * (r2 + 2.0 * y * y) + p2 * twice
        return column * self.fx + self.cx, row * self.fy + self.cy

    def rays(self, px: Points) -> Points:
        """Map (N, 2) pixels to (N, 3) directions with z = 1: a point at depth z is `z * ray`."""
        if len(px) == 0:
            return np.empty((0, 3))
        # OpenCV's default stops after 5 iterations and is 2 px off in the image's corners.
        until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-10)
        flat = cv2.undistortPointsIter(
            px.reshape(-1, 1, 2).astype(np.float64), *_for_opencv(self), UNTURNED, UNTURNED, until
        )
        rays = np.ones((len(px), 3))
        rays[:, :2] = flat.reshape(-1, 2)
        # Beyond the lens's image circle the iteration ends anywhere: neighbours would be far apart.
        wrong = ~(np.abs(self.project(rays) - px).max(axis=1) < UNDISTORTED_PX)  # nan is wrong too
        if wrong.any():
            rays[wrong, :2] = (px[wrong] - (self.cx, self.cy)) / (self.fx, self.fy)
        return rays


@lru_cache(maxsize=16)
def _for_opencv(lens: Lens) -> tuple[Points, Points]:
    """Return a lens's matrix and distortion: the sensing asks for some rays of each finger."""
    return lens.matrix, np.array(lens.distortion)


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """One device in one depth mode: what a profile is tied to."""

    serial: str
    depth_mode: str
    """As the SDK names it, e.g. `NFOV_UNBINNED`."""
    fps: int
    depth: Lens
    colour: Lens | None
    """None where colour is switched off."""
    colour_from_depth: Matrix4
    """(4, 4), mm: p_colour = M p_depth."""
