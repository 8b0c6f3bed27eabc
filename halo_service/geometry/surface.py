"""The surface: a plane in the camera's view, with its own frame.

Surface frame: origin at the top left as the user sits, x right, y towards the user,
z into the surface (right-handed), mm. Height above the surface is -z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from halo_service.geometry.camera import Lens, Points
from halo_service.geometry.matrix import Matrix4


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A named rectangle on a plane, and the depth camera's pose over it."""

    name: str
    width_mm: float
    height_mm: float
    camera_from_surface: Matrix4
    """(4, 4), mm: p_camera = M p_surface."""

    def from_camera(self, points: Points) -> Points:
        """Map (N, 3) points from the depth camera's frame to the surface's; mm."""
        rotation, origin = self.camera_from_surface[:3, :3], self.camera_from_surface[:3, 3]
        return np.asarray((points - origin) @ rotation, dtype=np.float64)

    def to_camera(self, points: Points) -> Points:
        """Map (N, 3) points from the surface's frame to the depth camera's; mm."""
        rotation, origin = self.camera_from_surface[:3, :3], self.camera_from_surface[:3, 3]
        return np.asarray(points @ rotation.T + origin, dtype=np.float64)

    def seen_at(self, px: Points, lens: Lens, lens_from_camera: Points) -> Points:
        """Map (N, 2) pixels of a lens to the (N, 2) places on the surface that they see; mm.

        `lens_from_camera`: (4, 4), mm, from the depth camera's frame: `Camera.colour_from_depth`
        for its colour lens, the identity for its depth lens. A ray that never meets the surface
        gives nan. Exact for a plane, whatever the lens's distortion.
        """
        lens_from_surface = lens_from_camera @ self.camera_from_surface
        rotation, origin = lens_from_surface[:3, :3], lens_from_surface[:3, 3]
        rays = lens.rays(px) @ rotation
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (rotation[:, 2] @ origin) / rays[:, 2:]
        met: Points = np.where(far > 0.0, far, np.nan) * rays - origin @ rotation
        return np.asarray(met[:, :2], dtype=np.float64)

    def in_picture(self, places: Points, lens: Lens, lens_from_camera: Points) -> Points:
        """Map (N, 2) places on the surface, mm, to the (N, 2) pixels of a lens that see them."""
        points = self.to_camera(np.column_stack([places, np.zeros(len(places))]))
        return lens.project(points @ lens_from_camera[:3, :3].T + lens_from_camera[:3, 3])

    def moved(self, plane_from_surface: Points, width_mm: float, height_mm: float) -> Surface:
        """Return another rectangle on the same plane, with the same name.

        `plane_from_surface`: (3, 3), mm: p_here = M (x, y, 1) of the new frame, a
        rotation and a shift.
        """
        moved = np.eye(4)
        moved[:2, :2], moved[:2, 3] = plane_from_surface[:2, :2], plane_from_surface[:2, 2]
        return Surface(self.name, width_mm, height_mm, self.camera_from_surface @ moved)


def from_view(
    normal: Points,
    distance_mm: float,
    *,
    name: str = "table",
    width_mm: float = 300.0,
    height_mm: float = 200.0,
) -> Surface:
    """Return a surface around the camera's optical axis; the image's top is its far edge.

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


def line_of_sight_deg(
    towards: tuple[float, float, float], pitch_deg: float, yaw_deg: float, surface: Surface
) -> float:
    """Return the angle between a finger and the line of sight; 0: the camera looks along it.

    `towards`: any point on the line of sight but the camera itself, in the camera's frame.
    """
    pitch, yaw = math.radians(pitch_deg), math.radians(yaw_deg)
    level = math.cos(pitch)
    finger = np.array([level * math.sin(yaw), -level * math.cos(yaw), math.sin(pitch)])
    along = surface.camera_from_surface[:3, :3] @ finger
    cosine = float(along @ np.array(towards)) / max(float(np.linalg.norm(towards)), 1e-9)
    return math.degrees(math.acos(min(max(cosine, -1.0), 1.0)))
