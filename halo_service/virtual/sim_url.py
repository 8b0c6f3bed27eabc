"""Read a source's name: `sim:drumming,seed=3,material=foam,camera_height_mm=600`.

Rule: no shell changes it. The older spelling `sim:drumming?seed=3&material=foam` needs quotes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, unquote

from halo_service.errors import UserError, suggestion
from halo_service.values import Finger, Side
from halo_service.virtual.pictures import findable
from halo_service.virtual.props import sheets
from halo_service.virtual.room import Room, draw_room
from halo_service.virtual.scenarios import CAMERAS, FOR_INSTALLATIONS, ROOM_CHANGES, SCENARIOS
from halo_service.virtual.sensor_model import SENSORS, SensorModel

DEFAULT = "demo"


def _side(text: str) -> Side:
    return {"left": Side.LEFT, "right": Side.RIGHT}[text]


def _sensor(text: str) -> SensorModel:
    if text not in SENSORS:
        raise UserError(f"unknown virtual sensor {text!r}; choose from: {', '.join(SENSORS)}.")
    return SENSORS[text]


def _sleeve(text: str) -> float | None:
    return None if text == "none" else float(text)


def _yes(text: str) -> bool:
    return {"yes": True, "no": False}[text]


def _fingers(text: str) -> tuple[Finger, ...]:
    return tuple(Finger[name.upper()] for name in _list(text))


def _list(text: str) -> tuple[str, ...]:
    return tuple(part for part in text.split(",") if part)


def _angles(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in _list(text))


OPTIONS: dict[str, tuple[str, Callable[[str], Any]]] = {
    "material": ("material", str),
    "camera_height_mm": ("camera_height_mm", float),
    "camera_pitch_deg": ("camera_pitch_deg", float),
    "camera_yaw_deg": ("camera_yaw_deg", float),
    "hand": ("dominant", _side),
    "noise": ("noise", float),
    "drop": ("drop", float),
    "light": ("light", float),
    "props": ("props", _list),
    "projected": ("projected", findable),
    "sheets": ("sheets", sheets),
    "blur_px": ("blur_px", float),
    "exposure_ms": ("exposure_ms", float),
    "labels": ("labels", str),
    "sensor": ("sensor", _sensor),
    "stray_light": ("sensor.stray_light", float),
    "illuminator_mm": ("sensor.illuminator_mm", float),
    "exposure_depth_ms": ("sensor.exposure_ms", float),
    "clock_drift_ppm": ("sensor.clock_drift_ppm", float),
    "slow_s_per_minute": ("sensor.slow_s_per_minute", float),
    "device": ("device", str),
    "mode": ("mode", str),
    "hand_size": ("user.size", float),
    "girth": ("user.girth", float),
    "pad_mm": ("user.pad_mm", float),
    "pad_g": ("user.pad_g", float),
    "skin": ("user.skin", float),
    "skin_offset_mm": ("user.skin_offset_mm", float),
    "nail_mm": ("user.nail_mm", float),
    "sleeve_mm": ("user.sleeve_mm", _sleeve),
    "curl": ("user.curl", float),
    "thumb_out": ("user.thumb_out", float),
    "nail_over_mm": ("user.nail_over_mm", float),
    "sleeve_infrared": ("user.sleeve_infrared", float),
    "rings": ("user.rings", _fingers),
    "seat_deg": ("seat_deg", float),
    "family": ("curve.family", str),
    "onset_mm": ("curve.onset_mm", float),
    "gain": ("curve.gain", float),
    "press_g": ("curve.press_g", float),
    "press_power": ("curve.press_power", float),
    "press_saturates": ("curve.press_saturates", _yes),
    "corner_fall": ("curve.corner_fall", float),
    "corner": ("curve.corner", int),
    "wider_high": ("curve.wider_high", float),
    "wider_pressed": ("curve.wider_pressed", float),
    "shift_mm": ("curve.shift_mm", float),
    "stretch": ("curve.stretch", float),
    "lopsided": ("curve.lopsided", float),
    "glow_mm": ("curve.glow_mm", float),
    "glow_reach_mm": ("curve.glow_reach_mm", float),
    "cameras": ("installation.cameras", int),
    "camera": ("installation.camera", int),
    "sync": ("installation.sync", str),
    "delay_us": ("installation.delay_us", float),
    "angles_deg": ("installation.angles_deg", _angles),
}
"""Option -> the field of the room, its user or its curve, and how to read it."""


KINDS: dict[Callable[[str], Any], str] = {
    int: "a whole number",
    float: "a number",
    _side: "left or right",
    _sleeve: "a number or none",
    _yes: "yes or no",
    _fingers: "names of fingers: thumb, index, middle, ring, little",
    _angles: "numbers, one for each camera",
}
"""How to name what a reader accepts."""


@dataclass(frozen=True, slots=True)
class SimRequest:
    """A scenario in a room."""

    scenario: str
    room: Room


def parse_sim_url(name: str = "", *, seed: int | None = None) -> SimRequest:
    """Read a name, e.g. `sim:drumming,seed=3`. `seed` wins over the name's.

    Raises UserError for an unknown scenario, option or value, naming the known ones.
    """
    scenario, mark, rest = _parted(name.removeprefix("sim").removeprefix(":"))
    scenario = scenario or DEFAULT
    if scenario not in SCENARIOS:
        hint = suggestion(scenario, SCENARIOS) or f"choose from: {', '.join(SCENARIOS)}."
        raise UserError(f"The virtual camera has no scenario {scenario!r}; {hint}")
    options = dict(parse_qsl(rest, keep_blank_values=True) if mark == "?" else _pairs(rest))
    options = CAMERAS.get(scenario, {}) | options
    drawn_seed = _read("seed", options.pop("seed", "1"), int)
    room = draw_room(seed if seed is not None else drawn_seed, **_named(options))
    if not room.installation.alone and scenario not in FOR_INSTALLATIONS:
        raise UserError(
            f"The scenario {scenario!r} is for one camera; with cameras="
            f"{room.installation.cameras} choose from: {', '.join(FOR_INSTALLATIONS)}."
        )
    return SimRequest(scenario, ROOM_CHANGES.get(scenario, _unchanged)(room))


def _parted(name: str) -> tuple[str, str, str]:
    """Return the scenario, the sign after it, and the options."""
    scenario = re.split("[?,]", name, maxsplit=1)[0]
    rest = name[len(scenario) :]
    return scenario, rest[:1], rest[1:]


def _pairs(text: str) -> list[tuple[str, str]]:
    """Read `key=value,key=value`; what has no `=` belongs to the list before it."""
    pairs: list[tuple[str, str]] = []
    for part in text.split(",") if text else []:
        key, equals, value = part.partition("=")
        if equals or not pairs:
            pairs.append((key, unquote(value)))
        else:
            pairs[-1] = (pairs[-1][0], f"{pairs[-1][1]},{unquote(part)}")
    return pairs


def _unchanged(room: Room) -> Room:
    return room


def _named(options: Mapping[str, str]) -> dict[str, Any]:
    named = {}
    for option, text in options.items():
        if option not in OPTIONS:
            known = ("seed", *OPTIONS)
            hint = suggestion(option, known) or f"choose from: {', '.join(known)}."
            raise UserError(f"The virtual camera has no option {option!r}; {hint}")
        field, read = OPTIONS[option]
        named[field] = _read(option, text, read)
    return named


def _read(option: str, text: str, read: Callable[[str], Any]) -> Any:
    try:
        return read(text)
    except (ValueError, KeyError):
        kind = KINDS[read]
        raise UserError(f"The virtual camera's {option} is {text!r}; it must be {kind}.") from None
