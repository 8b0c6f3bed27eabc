"""What the virtual Kinect measures: hands in a room to the frame that an SDK would hand us.

Rule: a frame is a function of (room, time, what is in view): no hidden state, so the same seed
gives the same bytes in any order. The truth stays outside: nothing of it is in the frame.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.values import Frame
from halo_service.virtual import bodies as shapes
from halo_service.virtual.bodies import Body
from halo_service.virtual.camera import factory
from halo_service.virtual.colour_image import Bgr, ColourImager
from halo_service.virtual.dents import dents_of
from halo_service.virtual.depth_image import DepthImager, Ideal
from halo_service.virtual.halo import dent_field, fading
from halo_service.virtual.noise import Electronics
from halo_service.virtual.room import Room
from halo_service.virtual.scene import Image
from halo_service.virtual.skeleton import PosedHand, User

EDGE_STEP_MM = 30.0
"""A step between neighbouring pixels above which the device gives no depth for most of them: the
signal is first lost at about 3 cm of finger height, then averaged (paper 4.1.3)."""
EDGE_LOSS = 0.7
"""Share of such pixels that read 0; the rest reads something in between. Chosen."""
MIXED_PX = 0.8
"""Blur of depth along a silhouette, one sigma; chosen."""
AVERAGED = 0.5
"""Share of its surroundings in what a low finger reads. Chosen."""
REACH = 2.2
"""Beyond this many radii a dent is below a thousandth of a millimetre."""

Box = tuple[slice, slice]


class Sensor:
    """A virtual Kinect over one room.

    `colour_times` draws the colour image at that fraction of its size and enlarges it (live);
    1 is full quality, 0 switches colour off. `started_us` is when the device was switched on.
    Raises UserError where the room asks for a picture that cannot be read.
    """

    def __init__(self, room: Room, *, colour_times: int = 1, started_us: int = 0) -> None:
        self.room = room
        self._user = _as_read(room)
        self.camera = factory()
        self.surface = room.surface()
        self._started_us = started_us
        self._imager = DepthImager(room, self.camera, self.surface)
        self._fade = fading(room.camera_height_mm, room.camera_yaw_deg, room.camera_pitch_deg)
        self._electronics = Electronics(room, self.camera.depth)
        self._colour_times = colour_times
        self._colour = (
            ColourImager(room, self.camera, self.surface, colour_times) if colour_times else None
        )
        self._shown: Bgr | None = None

    def show(self, picture: Bgr | None) -> None:
        """Let the projector show a picture, (h, w, 3) of its size, from now on; None: it is off.

        The room's own picture is forgotten.
        """
        self._shown = picture
        if self._colour is not None:
            self._colour.throw(picture)

    def furnish(self, room: Room) -> None:
        """Change what lies in the room or how its colour camera is set; the place stays.

        Takes as long as making a sensor; the projector goes on with what `show` gave it.
        """
        self.room = room
        self._user = _as_read(room)
        self._imager = DepthImager(room, self.camera, self.surface)
        if self._colour is None:
            return
        self._colour = ColourImager(room, self.camera, self.surface, self._colour_times)
        if self._shown is not None:
            self._colour.throw(self._shown)

    def frame(
        self, time_us: int, hands: Sequence[PosedHand] = (), things: Sequence[Body] = ()
    ) -> Frame:
        """The frame exposed at `time_us` with these hands and things in view."""
        rng = np.random.default_rng([self.room.seed, time_us])
        seen = [*(shapes.of_hand(self._user, hand) for hand in hands), *things]
        age_s = (time_us - self._started_us) / 1e6
        ideal = self._imager.draw(seen)
        lost = _soften_edges(ideal, self._imager.view.depth, rng)
        self._dent(hands, ideal)
        electronics = self._electronics
        depth = electronics.depth(ideal, age_s, rng)
        if lost is not None:
            depth[lost[0]][lost[1]] = 0
        infrared = electronics.infrared(ideal.infrared, rng)
        velocities = [*(hand.velocity_mm_s for hand in hands), *([np.zeros(3)] * len(things))]
        return Frame(time_us, depth, infrared, self._picture(age_s, seen, velocities, rng))

    def _dent(self, hands: Sequence[PosedHand], ideal: Ideal) -> None:
        """Press the halo into the table around every finger, in place."""
        dents = [d for hand in hands for d in dents_of(self.room, hand, self._fade)]
        if not dents:
            return
        places = np.array([[d.x_mm, d.y_mm, 0.0] for d in dents])
        px = self.camera.depth.project(self.surface.to_camera(places))
        # In pixels; a margin for the lens's distortion and for a table that comes nearer.
        reach = 1.15 * REACH * max(d.radius_mm for d in dents)
        reach *= self.camera.depth.fx / self.room.camera_height_mm
        box = _clipped(px.min(axis=0) - reach, px.max(axis=0) + reach, ideal.depth.shape)
        view = self._imager.view
        field = dent_field(dents, view.x_mm[box], view.y_mm[box]) * self._imager.top.halo[box]
        # Skin is not dented, but a low finger's averaged pixels share what lies around them.
        rise = (view.depth[box] - ideal.depth[box]) / np.float32(EDGE_STEP_MM)
        share = np.clip(np.float32(AVERAGED) * (np.float32(1.0) - rise), 0.0, 1.0)
        ideal.depth[box] += np.where(ideal.covered[box] > 0, share * field, field)

    def _picture(
        self,
        t_s: float,
        seen: Sequence[Body],
        velocities: Sequence[NDArray[np.float64]],
        rng: np.random.Generator,
    ) -> Bgr | None:
        if self._colour is None:
            return None
        image = self._colour.draw(t_s, seen, velocities)
        self._electronics.grain(image, rng)
        return self._colour.enlarge(image)


def _as_read(room: Room) -> User:
    """The user, with as much of the skin's offset as this sensor shows."""
    offset_mm = room.user.skin_offset_mm * room.sensor.skin_times
    return dataclasses.replace(room.user, skin_offset_mm=offset_mm)


def _soften_edges(
    ideal: Ideal, table: Image, rng: np.random.Generator
) -> tuple[Box, NDArray[np.bool_]] | None:
    """Mix pixels along silhouettes, in place; says where most of them read nothing."""
    x, y, width, height = cv2.boundingRect(ideal.covered)
    if width == 0:
        return None
    box = _clipped((x - 4, y - 4), (x + width + 4, y + height + 4), ideal.depth.shape)
    depth, covered = ideal.depth[box], ideal.covered[box]
    kernel = np.ones((3, 3), np.uint8)
    edge = cv2.dilate(covered, kernel) != cv2.erode(covered, kernel)
    step = cv2.dilate(depth, kernel) - cv2.erode(depth, kernel)
    lost = edge & (step > EDGE_STEP_MM) & (rng.random(depth.shape, np.float32) < EDGE_LOSS)
    mixed = cv2.GaussianBlur(depth, (0, 0), MIXED_PX)
    np.copyto(depth, mixed, where=edge)
    # A finger lower than that is averaged with the table around it: its outline fades.
    low = (covered > 0) & (table[box] - depth < EDGE_STEP_MM)
    averaged = (1.0 - AVERAGED) * depth + AVERAGED * cv2.blur(depth, (5, 5))
    np.copyto(depth, averaged, where=low)
    return box, np.asarray(lost, dtype=np.bool_)


def _clipped(
    low: tuple[float, float] | NDArray[np.float64],
    high: tuple[float, float] | NDArray[np.float64],
    shape: tuple[int, ...],
) -> Box:
    """Rows and columns from two corners (x, y), within the image."""
    (x0, y0), (x1, y1) = low, high
    rows = slice(max(0, int(y0)), max(0, min(shape[0], int(y1) + 1)))
    return rows, slice(max(0, int(x0)), max(0, min(shape[1], int(x1) + 1)))
