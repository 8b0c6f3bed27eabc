"""A virtual room where things lie: what the calibration's solvers see, and what is true there.

The virtual Kinect draws depth, infrared and colour; the truth is the room's own geometry.
"""

from __future__ import annotations

import dataclasses
from functools import cache

import cv2
import numpy as np

from halo_calibration.background import average
from halo_calibration.errors import Refused
from halo_calibration.plane import solve_plane, surface_from_view
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.profile import Background
from halo_service.virtual.camera import factory
from halo_service.virtual.colour_image import ColourImager
from halo_service.virtual.noise import GRAIN
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor

FRAMES = 4
"""Of depth that are averaged; a calibration takes sixty."""


def room(height_mm=500.0, pitch_deg=0.0, yaw_deg=0.0, **fields) -> Room:
    return Room(
        camera_height_mm=height_mm, camera_pitch_deg=pitch_deg, camera_yaw_deg=yaw_deg, **fields
    )


@cache
def camera_in(resolution: str) -> Camera:
    """The virtual device with another size of colour picture."""
    data = k4a.to_json(factory())
    return k4a.from_json(data, depth_mode="NFOV_UNBINNED", colour_resolution=resolution, fps=30)


class Place:
    """One room and one camera in it."""

    def __init__(self, room: Room, resolution: str = "720P") -> None:
        self.room = room
        self.camera = camera_in(resolution)
        self.truth = room.surface()
        self._imager = ColourImager(room, self.camera, self.truth, 1)
        self.background = self.depth(dataclasses.replace(room, sheets=()))
        self.plane = surface_from_view(solve_plane(self.background, self.camera))

    def depth(self, room: Room, things=()) -> Background:
        return average(self.depths(room, things))

    def depths(self, room: Room, things=()) -> list[np.ndarray]:
        sensor = Sensor(room, colour_times=0)
        return [sensor.frame(33_333 * n, things=things).depth for n in range(FRAMES)]

    def colour(self, shown=None, things=(), room: Room | None = None) -> np.ndarray:
        """(h, w, 3) what the colour camera sees, its noise included.

        `shown`: the projector's (height, width) picture, or None; `room`: this one, changed.
        """
        imager = self._imager if room is None else ColourImager(room, self.camera, self.truth, 1)
        imager.throw(None if shown is None else cv2.cvtColor(shown, cv2.COLOR_GRAY2BGR))
        picture = imager.draw(1.0, things, [np.zeros(3)] * len(things))
        noise = np.random.default_rng(5).normal(0.0, GRAIN * self.room.noise, picture.shape[:2])
        return np.clip(picture + noise[..., None] + 0.5, 0.0, 255.0).astype(np.uint8)

    def infrared(self) -> np.ndarray:
        """(h, w) uint8 what the depth camera sees."""
        frame = Sensor(self.room, colour_times=0).frame(1)
        return np.clip(frame.ir / 16.0, 0, 255).astype(np.uint8)

    def read_at(self, surface: Surface, places: np.ndarray) -> np.ndarray:
        """(N, 2) mm where a surface that was solved has (N, 2) places of the room's own."""
        px = self.truth.in_picture(places, self.camera.depth, np.eye(4))
        return surface.seen_at(px, self.camera.depth, np.eye(4))


def grid(width: float, height: float, inset: float = 0.0) -> np.ndarray:
    """(25, 2) places over a rectangle."""
    x = np.linspace(inset, width - inset, 5)
    y = np.linspace(inset, height - inset, 5)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def turned(x: float, y: float, turn_deg: float) -> np.ndarray:
    """(3, 3) a turn, then a shift."""
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    return np.array([[cos, -sin, x], [sin, cos, y], [0.0, 0.0, 1.0]])


def sent(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N, 2) points through a (3, 3) matrix."""
    there = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return there[:, :2] / there[:, 2:]


def refusal(call) -> str:
    """The sentence with which something is refused."""
    try:
        call()
    except Refused as refused:
        return str(refused)
    raise AssertionError("it was not refused")
