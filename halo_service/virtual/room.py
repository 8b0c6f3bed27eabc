"""One seed is one user at one place: what stays the same in all scenarios.

Rule: everything that a seed draws is drawn here. Each draw has its own random stream, so
overriding one field by name does not change the others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Points
from halo_service.geometry.surface import Surface
from halo_service.values import Side
from halo_service.virtual.camera import DEPTH_MODE, DEVICES, MODES, factory
from halo_service.virtual.halo import FAMILIES, HaloCurve
from halo_service.virtual.installation import places
from halo_service.virtual.installation.places import AREA_MM, Installation, Place, place_of
from halo_service.virtual.materials import MATERIALS, STUDIED, Material
from halo_service.virtual.projector import Projector
from halo_service.virtual.props import PROPS, Flat
from halo_service.virtual.sensor_model import KIND, TRUE, SensorModel
from halo_service.virtual.skeleton import User
from halo_service.virtual.users import (
    draw_curve,
    draw_user,
    draw_varied_curve,
    draw_varied_user,
    stream,
)

WIDTH_MM, HEIGHT_MM = AREA_MM


@dataclass(frozen=True, slots=True)
class Room:
    """A place and the person in it."""

    seed: int = 1
    camera_height_mm: float = 500.0
    """From the depth lens to the surface, along the optical axis."""
    camera_pitch_deg: float = 0.0
    """0 looks straight down, positive looks towards the far edge."""
    camera_yaw_deg: float = 0.0
    """Positive looks to the right."""
    material: str = "paper"
    user: User = field(default_factory=User)
    dominant: Side = Side.RIGHT
    curve: HaloCurve = field(default_factory=HaloCurve)
    noise: float = 1.0
    """Times the sensor's own noise."""
    drop: float = 0.005
    """Share of frames that never arrive."""
    light: float = 1.0
    """Room light, of a well-lit office."""
    props: tuple[str, ...] = ()
    """What lies on the table, from `props.PROPS`."""
    sheets: tuple[Flat, ...] = ()
    """Printed sheets that lie on the table, the last on top; `props.printed` makes one."""
    blur_px: float = 0.0
    """How far out of focus the colour camera is, one sigma."""
    exposure_ms: float | None = None
    """Of the colour camera; None: the camera follows the room light."""
    projected: str | None = None
    """What the projector shows: a name in `pictures.PICTURES` or a file; None: it is off."""
    projector: Projector = field(default_factory=Projector)
    labels: str | None = None
    """The label file of the scenario `labels`."""
    sensor: SensorModel = TRUE
    """The depth sensor's errors."""
    device: str = "kinect"
    """Of `camera.DEVICES`."""
    mode: str = DEPTH_MODE
    """Of `camera.MODES`."""
    seat_deg: float = 0.0
    """Where the user's arms come from, clockwise from above: 0 the near edge, 90 the left one,
    180 the far one, 270 the right one."""
    installation: Installation = field(default_factory=Installation)
    """The other cameras over the same table."""

    @property
    def place(self) -> Place:
        """This camera's area on the canvas."""
        return self.place_of(self.installation.camera)

    def place_of(self, number: int) -> Place:
        """Another camera's area on the canvas."""
        return place_of(self.installation, self.seed, number)

    @property
    def noise_seed(self) -> tuple[int, ...]:
        """Where this camera's random numbers start: no two cameras share their noise."""
        number = self.installation.camera
        return (self.seed,) if number == 1 else (self.seed, number)

    @property
    def surface_material(self) -> Material:
        """The table's material."""
        return MATERIALS[self.material]

    def camera(self) -> Camera:
        """The device, with a serial number of its own: a profile of one room fits no other."""
        device = factory(self.device, self.mode)
        number = self.installation.camera
        which = "" if number == 1 else f"-{number}"
        serial = f"{device.serial}-{self.seed}-{self.material}{which}"
        return dataclasses.replace(device, serial=serial)

    def surface(self) -> Surface:
        """The default surface, from the camera's view: 300 x 200 mm around the optical axis."""
        normal = _down(self.camera_pitch_deg, self.camera_yaw_deg)
        ahead = np.array([1.0, 0.0, 0.0])
        x = ahead - (ahead @ normal) * normal
        x /= np.linalg.norm(x)
        y = np.cross(normal, x)
        camera_from_surface = np.eye(4)
        camera_from_surface[:3, :3] = np.column_stack([x, y, normal])
        centre = np.array([0.0, 0.0, self.camera_height_mm])
        camera_from_surface[:3, 3] = centre - x * WIDTH_MM / 2.0 - y * HEIGHT_MM / 2.0
        return Surface("table", WIDTH_MM, HEIGHT_MM, camera_from_surface)


def _down(pitch_deg: float, yaw_deg: float) -> Points:
    """Unit normal into the surface, in the depth camera's frame."""
    pitch, yaw = np.radians(pitch_deg), np.radians(yaw_deg)
    return np.array([-np.sin(yaw), np.sin(pitch) * np.cos(yaw), np.cos(pitch) * np.cos(yaw)])


def draw_room(seed: int, **overrides: object) -> Room:
    """What a seed draws, with fields overridden by name; `user.size` and the like reach inside.

    With the sensor `kind` the users are plain too: tests that ask for it need nothing odd.
    Raises UserError for a negative seed, an unknown material, a value out of range.
    """
    if seed < 0:
        raise UserError(f"The virtual camera's seed is {seed}; give a whole number from 0 up.")
    number = overrides.get("installation.camera", 1)
    place = stream(seed, "camera" if number == 1 else f"camera {number}")
    plain = overrides.get("sensor", Room().sensor) == KIND
    drawn = Room(
        seed=seed,
        camera_height_mm=float(np.round(place.uniform(460.0, 620.0))),
        camera_pitch_deg=float(place.uniform(-3.0, 3.0)),
        camera_yaw_deg=float(place.uniform(-3.0, 3.0)),
        material=str(stream(seed, "material").choice(STUDIED)),
        user=draw_user(seed) if plain else draw_varied_user(seed),
        # 9 of the paper's 12 participants were right-handed (5.1).
        dominant=Side.RIGHT if stream(seed, "hand").uniform() < 0.75 else Side.LEFT,
        curve=draw_curve(seed) if plain else draw_varied_curve(seed),
        light=float(stream(seed, "light").uniform(0.6, 1.1)),
        seat_deg=0.0 if plain else _seat_deg(seed),
    )
    return check(_changed(drawn, overrides))


def _seat_deg(seed: int) -> float:
    """Most users sit at the near edge, the others at any of the other three."""
    draw = stream(seed, "seat")
    edge = float(draw.choice([0.0, 90.0, 180.0, 270.0], p=[0.55, 0.15, 0.15, 0.15]))
    return edge + float(draw.uniform(-20.0, 20.0))


def _changed(room: Room, overrides: Mapping[str, Any]) -> Room:
    """The room with fields of itself, its user, its curve and so on replaced."""
    parts = ("user", "curve", "sensor", "installation")
    inside: dict[str, dict[str, Any]] = {part: {} for part in parts}
    fields: dict[str, Any] = {}
    for name, value in overrides.items():
        part, _, field_name = name.rpartition(".")
        inside.get(part, fields)[field_name] = value
    for part, changes in inside.items():
        whole = fields.get(part, getattr(room, part))
        fields[part] = dataclasses.replace(whole, **changes)
    return dataclasses.replace(room, **fields)


LIMITS = {
    "camera_height_mm": (300.0, 1500.0),
    "camera_pitch_deg": (-60.0, 60.0),
    "camera_yaw_deg": (-60.0, 60.0),
    "noise": (0.0, 10.0),
    "drop": (0.0, 0.9),
    "light": (0.0, 4.0),
    "blur_px": (0.0, 20.0),
    "user.size": (0.7, 1.3),
    "user.girth": (0.8, 1.25),
    "user.pad_mm": (0.0, 4.0),
    "user.pad_g": (20.0, 400.0),
    "user.skin": (0.05, 1.0),
    "user.skin_offset_mm": (0.0, 30.0),
    "user.nail_mm": (0.0, 20.0),
    "user.curl": (0.0, 1.0),
    "sensor.stray_light": (0.0, 5.0),
    "sensor.illuminator_mm": (0.0, 50.0),
    "sensor.exposure_ms": (0.0, 33.0),
    "sensor.clock_drift_ppm": (-1000.0, 1000.0),
    "sensor.slow_s_per_minute": (0.0, 60.0),
    "user.thumb_out": (0.0, 1.0),
    "user.nail_over_mm": (0.0, 12.0),
    "user.sleeve_infrared": (0.05, 1.0),
    "seat_deg": (-360.0, 360.0),
    "curve.press_power": (0.0, 1.0),
    "curve.corner_fall": (0.0, 0.9),
    "curve.corner": (0, 3),
    "curve.wider_high": (0.0, 2.0),
    "curve.wider_pressed": (0.0, 2.0),
    "curve.shift_mm": (-10.0, 10.0),
    "curve.stretch": (0.5, 3.0),
    "curve.lopsided": (-0.6, 0.6),
    "curve.glow_mm": (0.0, 6.0),
    "curve.glow_reach_mm": (5.0, 100.0),
    "curve.onset_mm": (5.0, 40.0),
    "curve.gain": (0.0, 3.0),
    "curve.press_g": (20.0, 2000.0),
}
"""Accepted ranges; beyond them the images no longer make sense."""


def check(room: Room) -> Room:
    """Return the room; raise UserError where a field is out of range or unknown."""
    _check_names("material", [room.material], MATERIALS)
    _check_names("halo family", [room.curve.family], FAMILIES)
    _check_names("object", room.props, PROPS)
    _check_names("device", [room.device], DEVICES)
    _check_names("depth mode", [room.mode], MODES)
    places.check(room.installation)
    for name, (low, high) in LIMITS.items():
        part, _, field_name = name.rpartition(".")
        value = getattr(getattr(room, part) if part else room, field_name)
        if not low <= value <= high:
            raise UserError(
                f"The virtual camera's {field_name} is {value:g}; give {low:g} to {high:g}."
            )
    return room


def _check_names(what: str, names: Sequence[str], choices: Collection[str]) -> None:
    for name in names:
        if name not in choices:
            raise UserError(
                f"The virtual camera has no {what} {name!r}; choose from: {', '.join(choices)}."
            )
