"""A projector above the table: a pinhole run backwards.

Rule: pixels have (0, 0) at the outer corner of the top left pixel, as the wire's homography.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.virtual.mesh import Floats


@dataclass(frozen=True, slots=True)
class Projector:
    """Where it hangs and what it throws. Everything in the surface's frame, mm."""

    width_px: int = 1280
    height_px: int = 800
    """Resolution of the paper's class of LED projectors."""
    x_mm: float = 260.0
    y_mm: float = 40.0
    height_mm: float = 560.0
    """Of the lens: next to the camera, as in the paper's setup (5.1). Off the middle, so the
    picture on the table is a keystone."""
    aim_mm: tuple[float, float] = (150.0, 100.0)
    """Where its axis meets the table."""
    turn_deg: float = 1.5
    """About its axis; no projector is mounted straight."""
    throw: float = 1.25
    """Distance over picture width; chosen so that the picture reaches past the area."""
    brightness: float = 0.8
    """Of its white on the table, in that of the room light."""
    mirrored: bool = False
    """Set up as for a screen that is looked at from behind."""

    def pixels(self, points: Floats) -> NDArray[np.float32]:
        """(N, 2) projector pixels that light (N, 3) points."""
        image = points @ self._matrix()[:, :3].T + self._matrix()[:, 3]
        # What lies behind the lens is lit by no pixel: send it far outside.
        depth = np.where(image[:, 2] > 1.0, image[:, 2], 1e-6)
        return np.asarray(image[:, :2] / depth[:, None], dtype=np.float32)

    def projector_from_surface(self) -> Floats:
        """(3, 3) the true homography, mm on the table -> px, last element 1."""
        homography = self._matrix()[:, [0, 1, 3]]
        return np.asarray(homography / homography[2, 2], dtype=np.float64)

    def towards(self, points: Floats) -> Floats:
        """(N, 3) unit vectors from points to the lens."""
        away = np.array([self.x_mm, self.y_mm, -self.height_mm]) - points
        return np.asarray(away / np.linalg.norm(away, axis=1, keepdims=True), dtype=np.float64)

    def _matrix(self) -> Floats:
        """(3, 4) pinhole from the surface's frame."""
        lens = np.array([self.x_mm, self.y_mm, -self.height_mm])
        ahead = np.array([*self.aim_mm, 0.0]) - lens
        ahead /= np.linalg.norm(ahead)
        right = np.array([1.0, 0.0, 0.0]) - ahead[0] * ahead
        right /= np.linalg.norm(right)
        turn = np.radians(self.turn_deg)
        down = np.cross(ahead, right)
        right, down = (
            np.cos(turn) * right + np.sin(turn) * down,
            np.cos(turn) * down - np.sin(turn) * right,
        )
        rotation = np.stack([right, down, ahead])
        focal = self.throw * self.width_px
        inner = np.array(
            [
                [-focal if self.mirrored else focal, 0.0, self.width_px / 2.0],
                [0.0, focal, self.height_px / 2.0],
                [0.0, 0.0, 1.0],
            ]
        )
        return np.asarray(inner @ np.column_stack([rotation, -rotation @ lens]), dtype=np.float64)
