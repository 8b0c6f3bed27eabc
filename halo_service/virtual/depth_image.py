"""Ideal depth and infrared of a room with bodies in it, before the sensor's own errors.

Rule: geometry and light; the halo and the electronics come after.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.virtual import scene
from halo_service.virtual.bodies import Body
from halo_service.virtual.props import SOLID
from halo_service.virtual.render import rasterise
from halo_service.virtual.room import Room
from halo_service.virtual.scene import Image

GRAZING = 0.03
"""Least cosine by which a steep face still sends light back, chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class Ideal:
    """One moment without errors."""

    depth: Image
    """mm along the axis."""
    infrared: Image
    """Counts."""
    covered: NDArray[np.uint8]
    """255 where a body is in front of the table."""
    late: Image
    """mm that a body reads too far, already in `depth`; 0 beside the bodies."""


class DepthImager:
    """The depth lens over one room; what never moves is drawn once."""

    def __init__(self, room: Room, camera: Camera, surface: Surface) -> None:
        self._lens, self._surface = camera.depth, surface
        self.view = scene.look(camera.depth, surface.camera_from_surface)
        self.top = scene.top(self.view, room)
        self._light = scene.illumination(self.view)
        shape = self.view.depth.shape
        infrared = self.top.infrared * self.view.facing * self._light
        still = Ideal(
            self.view.depth.copy(), infrared, np.zeros(shape, np.uint8), np.zeros(shape, np.float32)
        )
        for name in room.props:
            if name in SOLID:
                self._put(SOLID[name](), still)
        self._still = still

    def draw(self, bodies: Sequence[Body]) -> Ideal:
        """The room with these bodies in it."""
        still = self._still
        ideal = Ideal(
            still.depth.copy(), still.infrared.copy(), still.covered.copy(), still.late.copy()
        )
        for body in bodies:
            self._put(body, ideal)
        return ideal

    def _put(self, body: Body, into: Ideal) -> None:
        points = self._surface.to_camera(body.vertices)
        seen = rasterise(self._lens, points, body.faces)
        normals = body.normals @ self._surface.camera_from_surface[:3, :3].T
        facing = -np.einsum("ij,ij->i", normals, points) / np.linalg.norm(points, axis=1)
        shine = body.infrared * np.clip(facing, GRAZING, 1.0)
        late = np.zeros(len(points)) if body.offset_mm is None else body.offset_mm
        at_pixel = seen.mix(np.column_stack([points[:, 2], shine, late]).astype(np.float32))
        behind = into.depth.ravel().take(seen.pixel) - into.late.ravel().take(seen.pixel)
        nearer = np.flatnonzero(at_pixel[:, 0] < behind)
        pixel, (depth, shine, late) = seen.pixel[nearer], at_pixel[nearer].T
        # Nearer than the table behind it: the light is stronger by the square of the distance.
        closer = (self.view.depth.ravel().take(pixel) / depth) ** 2
        into.infrared.ravel()[pixel] = shine * self._light.ravel().take(pixel) * closer
        into.depth.ravel()[pixel] = depth + late
        into.late.ravel()[pixel] = late
        into.covered.ravel()[pixel] = 255
