"""Ideal depth and infrared of a room with bodies in it, before the sensor's own errors.

Rule: geometry and light; the halo and the electronics come after.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.virtual import scene
from halo_service.virtual.bodies import Body
from halo_service.virtual.boxes import Box, box_of, grown, union
from halo_service.virtual.camera import MODES
from halo_service.virtual.exposure import SHARP_PX, smear
from halo_service.virtual.mesh import Floats, Ints, in_frame
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
    bodies: Box | None = None
    """Where bodies are, for the whole exposure or a part; None: nowhere."""

    def copy(self) -> Ideal:
        """Another one with images of its own."""
        return Ideal(
            self.depth.copy(),
            self.infrared.copy(),
            self.covered.copy(),
            self.late.copy(),
            self.moving.copy(),
            self.bodies,
        )

    @property
    def images(self) -> tuple[NDArray[Any], ...]:
        """All of them."""
        return self.depth, self.infrared, self.covered, self.late, self.moving

    def around(self, margin_px: int, above_px: int | None = None) -> Box | None:
        """The bodies' box with a margin, above and below `above_px`; None: there is no body."""
        if self.bodies is None:
            return None
        return grown(self.bodies, margin_px, above_px, self.depth.shape)


class DepthImager:
    """The depth lens over one room; what never moves is drawn once."""

    def __init__(self, room: Room, camera: Camera, surface: Surface) -> None:
        self._lens, self._from_surface = camera.depth, surface.camera_from_surface
        self._exposure_ms = room.sensor.exposure_ms * MODES[camera.depth_mode].exposure
        self.view = scene.look(camera.depth, surface.camera_from_surface)
        self.top = scene.top(self.view, room)
        self._light = scene.illumination(self.view) * np.float32(MODES[camera.depth_mode].signal)
        self._at_table = self._light * self.view.depth**2
        self._eye = surface.from_camera(np.zeros((1, 3)))[0]
        """(3,) where the lens is, in the surface's frame."""
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
        self._still = dataclasses.replace(still, bodies=box_of(still.covered))

        self._working, self._spoiled = still.copy(), False

    @property
    def empty(self) -> Ideal:
        """The room without moving bodies; not to be written to."""
        return self._still

    def draw(self, bodies: Sequence[Body], velocities: Sequence[Floats] | None = None) -> Ideal:
        """The room with these bodies in it. `velocities`: mm/s, in the surface's frame.

        It may be changed, until `wipe` or the next call.
        """
        if self._spoiled:
            self._working = self._still.copy()
        self._spoiled = True
        ideal = self._working
        boxes: list[Box | None] = []
        for body, velocity in zip(bodies, velocities or [STILL] * len(bodies), strict=True):
            streak_px = self._streak_px(velocity)
            if np.hypot(*streak_px) <= SHARP_PX:
                self._put(body, ideal)
                continue
            before = ideal.depth.copy(), ideal.infrared.copy(), ideal.late.copy()
            pixel = self._put(body, ideal)
            after = ideal.depth, ideal.infrared, ideal.late
            if len(pixel):
                boxes.append(smear(before, after, ideal.covered, ideal.moving, pixel, streak_px))
        boxes += [self._still.bodies, box_of(ideal.covered)]
        return dataclasses.replace(ideal, bodies=union(boxes))

    def wipe(self, changed: Box | None) -> None:
        """Empty the room again, where the last one that was drawn differs from the empty one."""
        if changed is not None:
            for image, still in zip(self._working.images, self._still.images, strict=True):
                image[changed] = still[changed]
        self._spoiled = False

    def _streak_px(self, velocity: Floats) -> tuple[float, float]:
        """How far something at the table moves in the image within an exposure."""
        moved_mm = self._from_surface[:3, :3] @ velocity * (self._exposure_ms / 1000.0)
        px_per_mm = self._lens.fx / self._from_surface[2, 3]
        return float(moved_mm[0] * px_per_mm), float(moved_mm[1] * px_per_mm)

    def _put(self, body: Body, into: Ideal) -> Ints:
        """Put a body where it is nearer than what is there, in place; return its flat pixels."""
        seen = rasterise(self._lens, in_frame(self._from_surface, body.vertices), body.faces)
        behind = into.depth.ravel().take(seen.pixel) - into.late.ravel().take(seen.pixel)
        seen = seen.only(np.flatnonzero(seen.depth < behind))
        pixel, depth = seen.pixel, seen.depth
        shine = seen.mix(self._shine(body)[None])[0]
        # Nearer than the table behind it: the light is stronger by the square of the distance.
        shine *= self._at_table.ravel().take(pixel)
        shine /= depth * depth
        into.infrared.ravel()[pixel] = shine
        if body.offset_mm is not None:
            late = body.offset_mm.take(seen.corner)
            into.late.ravel()[pixel] = late
            depth = depth + late
        else:
            into.late.ravel()[pixel] = 0.0
        into.depth.ravel()[pixel] = depth
        into.covered.ravel()[pixel] = 255
        return pixel

    def _shine(self, body: Body) -> NDArray[np.float32]:
        """(V,) how bright a body's skin is in light from the camera."""
        x, y, z = (self._eye - body.vertices).T
        nx, ny, nz = body.normals.T
        facing = (nx * x + ny * y + nz * z) / np.sqrt(x * x + y * y + z * z)
        return np.asarray(body.infrared * np.clip(facing, GRAZING, 1.0), dtype=np.float32)


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
