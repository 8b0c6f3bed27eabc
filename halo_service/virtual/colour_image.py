"""The colour camera: room light, projected light, exposure.

Rule: as the depth image, but for the second lens, in light that changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.virtual import scene
from halo_service.virtual.bodies import Body
from halo_service.virtual.camera import shrunk
from halo_service.virtual.mesh import Floats, Ints, in_frame
from halo_service.virtual.pictures import Picture, Show, show, still
from halo_service.virtual.props import SOLID
from halo_service.virtual.render import rasterise
from halo_service.virtual.room import Room
from halo_service.virtual.scene import Image

LAMP = np.array([-0.35, -0.35, -0.87])
"""Towards the room's lamp, in the surface's frame: above, to the far left. Chosen."""
AMBIENT = 0.45
"""Share of the room light that comes from everywhere, chosen."""
EXPOSURE_MS, LONGEST_MS, SHORTEST_MS = 8.0, 33.0, 0.5
"""Exposure in a well-lit office and its limits at 30 frames a second; chosen. Darker rooms are
exposed longer: then moving hands smear, and projected light is too bright."""
SMEAR_PX = 1.5
"""Less movement than that within an exposure is not drawn."""
SHADOW_TIMES = 4
"""A hand's shadow in the projector's light is drawn at that fraction of its resolution."""

Bgr = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class _Lit:
    """What each pixel shows."""

    depth: Image
    """(H, W) mm along the lens's axis."""
    room: Bgr
    """(H, W, 3) in room light."""
    thrown: Bgr
    """(H, W, 3) reflectance of projected light; empty where the projector is off."""
    source: Image
    """(H, W, 2) the projector's pixel that lights it; likewise."""

    def copy(self) -> _Lit:
        return _Lit(self.depth.copy(), self.room.copy(), self.thrown.copy(), self.source.copy())


class ColourImager:
    """The colour lens over one room, drawn `times` smaller than it is."""

    def __init__(self, room: Room, camera: Camera, surface: Surface, times: int) -> None:
        if camera.colour is None:
            raise ValueError("the camera has no colour lens")
        self._full = camera.colour
        self._lens = shrunk(camera.colour, times)
        self._from_surface = camera.colour_from_depth @ surface.camera_from_surface
        self._room = room
        self._projector = room.projector
        self._blur_px = room.blur_px / times
        light = max(room.light, 1e-3)
        exposure_ms = EXPOSURE_MS / light if room.exposure_ms is None else room.exposure_ms
        self.exposure_ms = float(np.clip(exposure_ms, SHORTEST_MS, LONGEST_MS))
        self._room_gain = 255.0 * room.light * self.exposure_ms / EXPOSURE_MS
        self._throw_gain = room.projector.brightness * self.exposure_ms / EXPOSURE_MS
        self._show: Show | None = None
        if room.projected is not None:
            self._show = show(room.projected, room.projector.width_px, room.projector.height_px)
        self._table = self._furnished()
        self._thrown: tuple[Picture, Picture] | None = None
        """The last picture, and how its pixels run together in those of the lens."""

    def throw(self, picture: Picture | None) -> None:
        """Let the projector show another picture from now on; None switches it off."""
        was_off = self._show is None
        self._show = None if picture is None else still(picture)
        if was_off != (picture is None):
            self._table = self._furnished()

    def draw(self, t_s: float, bodies: Sequence[Body], velocities: Sequence[Floats]) -> Bgr:
        """The picture at a time. `velocities` of the bodies, mm/s in the surface's frame."""
        now = self._table.copy()
        for body, velocity in zip(bodies, velocities, strict=True):
            before = now.room.copy() if self._smears(velocity) else None
            pixel = self._write(body, now)
            if before is not None:
                self._smear(now.room, before, pixel, velocity)
        lit = now.room
        if self._show is not None:
            lit = self._throw(now, self._merged(self._show(t_s)), bodies)
        if self._blur_px == 0.0:
            return lit
        return np.asarray(cv2.GaussianBlur(lit, (0, 0), self._blur_px), dtype=np.uint8)

    def enlarge(self, image: Bgr) -> Bgr:
        """To the lens's full size."""
        if image.shape[1] == self._full.width:
            return image
        size = self._full.width, self._full.height
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_LINEAR), dtype=np.uint8)

    def _merged(self, picture: Picture) -> Picture:
        """The picture as coarse as the lens sees it: a pixel averages the light of its area."""
        if self._thrown is None or self._thrown[0] is not picture:
            step = np.abs(np.diff(self._table.source[..., 0], axis=1))
            size = max(1, round(float(np.median(step))) | 1)  # odd, or it would shift the picture
            merged = cv2.blur(picture, (size, size)) if size > 1 else picture
            self._thrown = picture, np.asarray(merged, dtype=np.uint8)
        return self._thrown[1]

    def _furnished(self) -> _Lit:
        """The table and what always is on it."""
        table = self._bare_table(self._room, self._show is not None)
        for name in self._room.props:
            if name in SOLID:
                self._write(SOLID[name](), table)
        return table

    def _bare_table(self, room: Room, thrown: bool) -> _Lit:
        view = scene.look(self._lens, self._from_surface)
        colour = scene.top(view, room).colour
        # The lamp is to the far left: the table is a little brighter there.
        lamp = 1.0 - 0.1 * np.tanh((view.x_mm + view.y_mm) / 600.0)[..., None]
        lit = np.clip(self._room_gain * lamp * colour, 0.0, 255.0).astype(np.uint8)
        if not thrown:
            dark = np.empty((0, 0, 3), np.uint8), np.empty((0, 0, 2), np.float32)
            return _Lit(view.depth.copy(), lit, *dark)
        flat = np.zeros(view.x_mm.shape, np.float32)
        points = np.stack([view.x_mm, view.y_mm, flat], axis=-1).reshape(-1, 3).astype(np.float64)
        facing = np.clip(-self._projector.towards(points)[:, 2], 0.0, 1.0)
        reflect = np.clip(255.0 * colour * facing.reshape(*flat.shape, 1), 0.0, 255.0)
        source = self._projector.pixels(points).reshape(*flat.shape, 2)
        return _Lit(view.depth.copy(), lit, reflect.astype(np.uint8), source - np.float32(0.5))

    def _write(self, body: Body, into: _Lit) -> Ints:
        """Put a body where it is nearer than what is there, in place; returns its flat pixels."""
        seen = rasterise(self._lens, in_frame(self._from_surface, body.vertices), body.faces)
        seen = seen.only(np.flatnonzero(seen.depth < into.depth.ravel().take(seen.pixel)))
        normal_x, normal_y, normal_z = body.normals.T
        towards_lamp = normal_x * LAMP[0] + normal_y * LAMP[1] + normal_z * LAMP[2]
        lamp = AMBIENT + (1.0 - AMBIENT) * np.clip(towards_lamp, 0.0, 1.0)
        colour = body.colour.T
        at_vertex = [colour * (self._room_gain * lamp)]
        if self._show is not None:
            towards = self._projector.towards(body.vertices)
            facing = np.clip(np.einsum("ij,ij->i", body.normals, towards), 0.0, 1.0)
            at_vertex += [255.0 * colour * facing, self._projector.pixels(body.vertices).T - 0.5]
        at_pixel = seen.mix(np.concatenate(at_vertex).astype(np.float32))
        into.depth.ravel()[seen.pixel] = seen.depth
        _paint(into.room, seen.pixel, at_pixel[:3])
        if self._show is not None:
            _paint(into.thrown, seen.pixel, at_pixel[3:6])
            into.source.reshape(-1, 2)[seen.pixel] = at_pixel[6:8].T
        return seen.pixel

    def _throw(self, now: _Lit, picture: Bgr, bodies: Sequence[Body]) -> Bgr:
        """Add the projector's light; bodies cast shadows on the table, not on themselves."""
        light = _sample(picture, now.source)
        if bodies:
            shade = _sample(self._shadow(bodies), self._table.source)
            table = (now.source == self._table.source).all(axis=2)
            light[table & (shade > 127)] = 0
        thrown = cv2.multiply(now.thrown, light, scale=self._throw_gain / 255.0)
        return np.asarray(cv2.add(now.room, thrown), dtype=np.uint8)

    def _shadow(self, bodies: Sequence[Body]) -> Bgr:
        """(height, width) of the projector: 255 where a body stops its light."""
        projector, times = self._projector, SHADOW_TIMES
        small = np.zeros((projector.height_px // times, projector.width_px // times), np.uint8)
        for body in bodies:
            px = np.clip(projector.pixels(body.vertices) / times, -9999.0, 9999.0).astype(np.int32)
            a, b, c = (px[body.faces[:, k]] for k in range(3))
            turned = np.cross(b - a, c - a) < 0
            for triangle in px[body.faces[turned]]:
                cv2.fillConvexPoly(small, triangle, (255,))
        size = projector.width_px, projector.height_px
        return np.asarray(cv2.resize(small, size, interpolation=cv2.INTER_NEAREST), np.uint8)

    def _smears(self, velocity: Floats) -> bool:
        return bool(np.hypot(*self._streak(velocity)) > SMEAR_PX)

    def _streak(self, velocity: Floats) -> tuple[float, float]:
        """How far something at the table moves within an exposure, px."""
        moved = self._from_surface[:3, :3] @ velocity * (self.exposure_ms / 1000.0)
        scale = self._lens.fx / self._from_surface[2, 3]
        return float(moved[0] * scale), float(moved[1] * scale)

    def _smear(self, image: Bgr, before: Bgr, pixel: Ints, velocity: Floats) -> None:
        """Draw a moving body as a streak over what was there before it, in place."""
        if len(pixel) == 0:
            return
        mask = np.zeros(image.shape[:2], np.float32)
        mask.ravel()[pixel] = 1.0
        dx, dy = self._streak(velocity)
        reach = int(np.ceil(max(abs(dx), abs(dy)))) + 1
        x, y, width, height = cv2.boundingRect((mask > 0).astype(np.uint8))
        box = (
            slice(max(0, y - reach), y + height + reach),
            slice(max(0, x - reach), x + width + reach),
        )
        kernel = np.zeros((2 * reach + 1, 2 * reach + 1), np.uint8)
        ends = [(round(reach + s * dx / 2), round(reach + s * dy / 2)) for s in (-1, 1)]
        cv2.line(kernel, ends[0], ends[1], (1,))
        line = kernel.astype(np.float32) / kernel.sum()
        share = cv2.filter2D(mask[box], -1, line)[..., None]
        body = cv2.filter2D(image[box].astype(np.float32) * mask[box][..., None], -1, line)
        image[box] = (before[box] * (1.0 - share) + body).astype(np.uint8)


def _paint(image: Bgr, pixel: Ints, colour: Image) -> None:
    """Set flat pixels of an image to (3, N) colours, in place."""
    channels, first = image.reshape(-1), 3 * pixel
    for channel, values in enumerate(np.minimum(colour, np.float32(255.0))):
        channels[first + channel] = values


def _sample(picture: Bgr, source: Image) -> Bgr:
    """Look up a picture at (H, W, 2) pixels; black beyond its edges."""
    x, y = source[..., 0], source[..., 1]
    found = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return np.asarray(found, dtype=np.uint8)
