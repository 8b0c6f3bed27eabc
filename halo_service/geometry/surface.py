"""The surface: a plane in the camera's view, with a frame of its own.

Surface frame: origin at the top left as the user sits, x right, y towards the user,
z into the surface (right-handed), mm. Height above the surface is -z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from halo_service.geometry.camera import Points


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A named rectangle on a plane, and where the depth camera stands over it."""

    name: str
    width_mm: float
    height_mm: float
    camera_from_surface: Points
    """(4, 4), mm: p_camera = M p_surface."""

    def from_camera(self, points: Points) -> Points:
        """Map (N, 3) points from the depth camera's frame to the surface's; mm."""
        rotation, origin = self.camera_from_surface[:3, :3], self.camera_from_surface[:3, 3]
        return np.asarray((points - origin) @ rotation, dtype=np.float64)

    def to_camera(self, points: Points) -> Points:
        """Map (N, 3) points from the surface's frame to the depth camera's; mm."""
        rotation, origin = self.camera_from_surface[:3, :3], self.camera_from_surface[:3, 3]
        return np.asarray(points @ rotation.T + origin, dtype=np.float64)
