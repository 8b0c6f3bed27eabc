"""Ideal depth and infrared of a room with bodies in it, before the sensor's own errors.

Rule: geometry and light; the halo and the electronics come after.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.virtual import scene
from halo_service.virtual.bodies import Body
from halo_service.virtual.camera import MODES
from halo_service.virtual.exposure import SHARP_PX, smear
from halo_service.virtual.mesh import Floats, Ints, lengths
from halo_service.virtual.props import SOLID
from halo_service.virtual.render import rasterise
from halo_service.virtual.room import Room
from halo_service.virtual.scene import Image

DARK, BLACK = 0.25, 0.05
"""Infrared reflectance below which a surface begins to read too far, and where it does so most;
chosen."""
STILL = np.zeros(3)
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
    """mm that a body reads too far, already in `depth`; 0 where no body is."""
    moving: NDArray[np.uint8]
    """255 where a body is for a part of the exposure only."""

    def copy(self) -> Ideal:
        """Another one with images of its own."""
        return Ideal(
            self.depth.copy(),
            self.infrared.copy(),
            self.covered.copy(),
            self.late.copy(),
            self.moving.copy(),
        )


class DepthImager:
    """The depth lens over one room; what never moves is drawn once."""

    def __init__(self, room: Room, camera: Camera, surface: Surface) -> None:
        self._lens, self._surface = camera.depth, surface
        self._exposure_ms = room.sensor.exposure_ms
        self.view = scene.look(camera.depth, surface.camera_from_surface)
        self.top = scene.top(self.view, room)
        self._light = scene.illumination(self.view) * np.float32(MODES[camera.depth_mode].signal)
        shape = self.view.depth.shape
        infrared = self.top.infrared * self.view.facing * self._light
        self.table = self.view.depth + surface_offset(room, self._lens, self.top.infrared)
        """(H, W) mm, what the bare table reads without noise."""
        nothing = np.zeros(shape, np.uint8)
        late = np.zeros(shape, np.float32)
        still = Ideal(self.table.copy(), infrared, nothing, late, nothing.copy())
        for name in room.props:
            if name in SOLID:
                self._put(SOLID[name](), still)
        self._still = still

    def draw(self, bodies: Sequence[Body], velocities: Sequence[Floats] | None = None) -> Ideal:
        """The room with these bodies in it. `velocities`: mm/s, in the surface's frame."""
        ideal = self._still.copy()
        for body, velocity in zip(bodies, velocities or [STILL] * len(bodies), strict=True):
            streak_px = self._streak_px(velocity)
            if np.hypot(*streak_px) <= SHARP_PX:
                self._put(body, ideal)
                continue
            before = ideal.depth.copy(), ideal.infrared.copy(), ideal.late.copy()
            pixel = self._put(body, ideal)
            after = ideal.depth, ideal.infrared, ideal.late
            if len(pixel):
                smear(before, after, ideal.covered, ideal.moving, pixel, streak_px)
        return ideal

    def _streak_px(self, velocity: Floats) -> tuple[float, float]:
        """How far something at the table moves in the image within an exposure."""
        camera_from_surface = self._surface.camera_from_surface
        moved_mm = camera_from_surface[:3, :3] @ velocity * (self._exposure_ms / 1000.0)
        px_per_mm = self._lens.fx / camera_from_surface[2, 3]
        return float(moved_mm[0] * px_per_mm), float(moved_mm[1] * px_per_mm)

    def _put(self, body: Body, into: Ideal) -> Ints:
        """Put a body where it is nearer than what is there, in place; return its flat pixels."""
        points = self._surface.to_camera(body.vertices)
        seen = rasterise(self._lens, points, body.faces)
        normals = body.normals @ self._surface.camera_from_surface[:3, :3].T
        facing = -np.einsum("ij,ij->i", normals, points) / lengths(points)
        shine = body.infrared * np.clip(facing, GRAZING, 1.0)
        at_pixel = seen.mix(np.stack([points[:, 2], shine]).astype(np.float32))
        behind = into.depth.ravel().take(seen.pixel) - into.late.ravel().take(seen.pixel)
        nearer = np.flatnonzero(at_pixel[0] < behind)
        pixel, (depth, shine) = seen.pixel.take(nearer), at_pixel.take(nearer, axis=1)
        late = np.zeros(len(pixel), np.float32)
        if body.offset_mm is not None:
            late = body.offset_mm.take(seen.corners[0].take(nearer))
        # Nearer than the table behind it: the light is stronger by the square of the distance.
        closer = (self.view.depth.ravel().take(pixel) / depth) ** 2
        into.infrared.ravel()[pixel] = shine * self._light.ravel().take(pixel) * closer
        into.depth.ravel()[pixel] = depth + late
        into.late.ravel()[pixel] = late
        into.covered.ravel()[pixel] = 255
        return pixel


def surface_offset(room: Room, lens: Lens, reflectance: Image) -> Image:
    """(H, W) mm that the table reads too far: some materials do, and dark ones towards the edge."""
    model = room.sensor
    darkness = np.clip((DARK - reflectance) / (DARK - BLACK), 0.0, 1.0)
    rows, columns = np.mgrid[: lens.height, : lens.width]
    off_axis = np.hypot(rows - lens.cy, columns - lens.cx) / (lens.height / 2.0)
    return np.asarray(
        room.surface_material.offset_mm * model.material_times
        + model.dark_offset_mm * darkness * off_axis**2,
        dtype=np.float32,
    )
