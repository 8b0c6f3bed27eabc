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


def from_view(
    normal: Points,
    distance_mm: float,
    *,
    name: str = "table",
    width_mm: float = 300.0,
    height_mm: float = 200.0,
) -> Surface:
    """Lay a surface around the camera's optical axis; the image's top is its far edge.

    `normal`: (3,) unit, into the surface, in the depth camera's frame; `distance_mm`: from the
    lens to the plane along the optical axis.
    """
    ahead = np.array([1.0, 0.0, 0.0])
    x = ahead - (ahead @ normal) * normal
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    camera_from_surface = np.eye(4)
    camera_from_surface[:3, :3] = np.column_stack([x, y, normal])
    centre = np.array([0.0, 0.0, distance_mm])
    camera_from_surface[:3, 3] = centre - x * width_mm / 2.0 - y * height_mm / 2.0
    return Surface(name, width_mm, height_mm, camera_from_surface)
