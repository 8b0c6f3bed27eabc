"""A virtual room where things lie: what the calibration's solvers see, and what is true there.

The virtual camera draws depth, infrared and colour; the truth is the room's own geometry.
"""

from __future__ import annotations

import dataclasses
from functools import cache

import cv2
import numpy as np

from halo_calibration.boards.board import Printed
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.anchor import Anchored, anchor_pose
from halo_calibration.solvers.background import average
from halo_calibration.solvers.homography import HomographyFit
from halo_calibration.solvers.plane import solve_plane, surface_from_view
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.profile import Background
from halo_service.virtual.camera import factory
from halo_service.virtual.colour_image import ColourImager
from halo_service.virtual.noise import GRAIN
from halo_service.virtual.projector import Projector
from halo_service.virtual.props import printed, standing
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor
from tests.kind_sensor import KIND_ROOM

Distortion = tuple[float, float, float, float, float, float, float, float]
FRAMES = 8
"""Of depth that are averaged; a calibration takes thirty to sixty. Four leave a marker's tilt at
1 m with 0.5 degrees of noise."""


def room(height_mm=500.0, pitch_deg=0.0, yaw_deg=0.0, **fields) -> Room:
    return Room(
        camera_height_mm=height_mm,
        camera_pitch_deg=pitch_deg,
        camera_yaw_deg=yaw_deg,
        **KIND_ROOM,
        **fields,
    )


@cache
def camera_in(resolution: str) -> Camera:
    """The virtual device with another size of colour picture."""
    data = k4a.to_json(factory())
    return k4a.from_json(data, depth_mode="NFOV_UNBINNED", colour_resolution=resolution, fps=30)


class Place:
    """One room and one camera in it."""

    def __init__(
        self, room: Room, resolution: str = "720P", distortion: Distortion | None = None
    ) -> None:
        """`distortion`: the colour lens's, instead of the virtual device's."""
        self.room = room
        self.camera = camera_in(resolution)
        if distortion is not None:
            colour = dataclasses.replace(self.camera.colour, distortion=distortion)
            self.camera = dataclasses.replace(self.camera, colour=colour)
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

    def infrared(self, room: Room) -> np.ndarray:
        """(h, w) uint8 what the depth camera sees in this room, changed."""
        frame = Sensor(room, colour_times=0).frame(1)
        return np.clip(frame.ir / 16.0, 0, 255).astype(np.uint8)

    def read_at(self, surface: Surface, places: np.ndarray) -> np.ndarray:
        """(N, 2) mm where a surface that was solved has (N, 2) places of the room's own."""
        px = self.truth.in_picture(places, self.camera.depth, np.eye(4))
        return surface.seen_at(px, self.camera.depth, np.eye(4))


def hung(keystone_deg: float, width_px: int = 1280, height_px: int = 800) -> Projector:
    """A projector at this angle to the vertical."""
    aside = 560.0 * np.tan(np.radians(keystone_deg))
    return Projector(
        width_px=width_px,
        height_px=height_px,
        x_mm=150.0 + 0.6 * aside,
        y_mm=100.0 - 0.8 * aside,
    )


def posed(x: float, y: float, z: float, turn_deg: float, tilt_deg=0.0, roll_deg=0.0) -> np.ndarray:
    """surface_from_anchor, (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3] = _about(2, turn_deg) @ _about(0, tilt_deg) @ _about(1, roll_deg)
    matrix[:3, 3] = (x, y, z)
    return matrix


def _about(axis: int, degrees: float) -> np.ndarray:
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = ((1, 2), (0, 2), (0, 1))[axis]
    turn = np.eye(3)
    turn[[i, j], [i, j]] = cos
    turn[i, j], turn[j, i] = -sin, sin
    return turn


def anchored(place: Place, marker: Printed, there: np.ndarray) -> Anchored:
    """Solve a marker that is put in a place: flat ones are printed, others stand."""
    width_mm = 1.4 * marker.size_mm
    picture = marker.picture(width_mm, width_mm, 5)
    bare, things = place.room, ()
    if there[2, 3] == 0.0:
        turn_deg = np.degrees(np.arctan2(there[1, 0], there[0, 0]))
        sheet = printed(picture, there[0, 3], there[1, 3], width_mm, turn_deg)
        furnished = dataclasses.replace(bare, sheets=(sheet,))
    else:
        things, furnished = (standing(picture, width_mm, there),), bare
    return anchor_pose(
        place.colour(things=things, room=furnished),
        marker,
        place.camera,
        place.plane,
        place.background,
        place.depths(furnished, things),
    )


def pose_error(found: Anchored, there: np.ndarray) -> tuple[float, float]:
    """How far a marker was found from where it is: mm and degrees."""
    ours = np.linalg.inv(found.anchor.anchor_from_surface)
    cos = (np.trace(ours[:3, :3].T @ there[:3, :3]) - 1.0) / 2.0
    off_deg = np.degrees(np.arccos(np.clip(cos, -1.0, 1.0)))
    return float(np.linalg.norm(ours[:3, 3] - there[:3, 3])), float(off_deg)


def off_px(place: Place, solved: HomographyFit) -> np.ndarray:
    """(25,) how far from where it should be light falls that is aimed at what a touch reads."""
    places = grid(300.0, 200.0)
    read = place.read_at(place.plane, places)
    aimed = sent(solved.projector.projector_from_surface, read)
    truth = sent(place.room.projector.projector_from_surface(), places)
    return np.linalg.norm(aimed - truth, axis=1)


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
    except CalibrationError as refused:
        return str(refused)
    raise AssertionError("it was not refused")
