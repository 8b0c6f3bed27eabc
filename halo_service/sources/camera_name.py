"""Read a camera's name: `femto-bolt,serial=CL8FC3100G7,mode=NFOV_UNBINNED,power_line_hz=50`.

Rule: pure. No shell changes it. The older spelling `azure-kinect:SERIAL` still works.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

from halo_service.errors import UserError, suggestion
from halo_service.geometry.k4a import DEPTH_FPS

CameraKind = Literal["azure-kinect", "femto-bolt", "femto-mega"]
CAMERA_KINDS: tuple[CameraKind, ...] = ("azure-kinect", "femto-bolt", "femto-mega")
TITLES: dict[CameraKind, str] = {
    "azure-kinect": "Azure Kinect",
    "femto-bolt": "Femto Bolt",
    "femto-mega": "Femto Mega",
}
"""What people call them."""
MODES = tuple(DEPTH_FPS)
"""The depth modes by the Azure Kinect's names; a Femto has the same."""
MOST_DELAY_US = 1_000_000 // max(DEPTH_FPS.values())
"""A delay of a frame or more would shift the camera by a frame."""

Sync = Literal["alone", "primary", "secondary"]
SYNCS: tuple[Sync, ...] = ("alone", "primary", "secondary")


@dataclass(frozen=True, slots=True)
class CameraOptions:
    """The options of a camera."""

    serial: str = ""
    """Serial number; empty: the first that can be opened."""
    mode: str = MODES[0]
    """Depth mode."""
    exposure_ms: float | None = None
    """Exposure of the colour camera; None: automatic."""
    gain: int | None = None
    """Gain of the colour camera, in the device's own steps; None: the device's setting."""
    power_line_hz: int | None = None
    """50 or 60: light that flickers with it gives no stripes; None: the device's setting."""
    sync: Sync = "alone"
    """Role on a sync cable."""
    sync_delay_us: int = 0
    """How long after the primary camera a secondary one exposes: 160 or more for each camera
    keeps the light of one out of the other's image (Azure Kinect documentation)."""
    address: str = ""
    """Network address of a Femto Mega; empty: USB."""


def kind_of(name: str) -> CameraKind | None:
    """Return which camera a source's name means; None: no camera."""
    word = name.replace(":", ",").partition(",")[0]
    return next((kind for kind in CAMERA_KINDS if kind == word), None)


def parse_camera_name(name: str) -> tuple[CameraKind, CameraOptions]:
    """Read a camera's name. Raises `UserError` for an unknown camera, option or value."""
    kind = kind_of(name)
    if kind is None:
        raise UserError(f"source: unknown camera '{name}'; choose from: {', '.join(CAMERA_KINDS)}")
    rest = name[len(kind) :]
    parts = [part.strip() for part in rest[1:].split(",") if part.strip()]
    if rest.startswith(":") and parts and "=" not in parts[0]:
        parts[0] = f"serial={parts[0]}"
    options = CameraOptions()
    for part in parts:
        options = replace(options, **_option(kind, part))
    if options.sync_delay_us and options.sync != "secondary":
        raise UserError(
            "source: sync_delay_us works only with sync=secondary: a camera that waits for "
            "another's signal"
        )
    return kind, options


def _option(kind: CameraKind, part: str) -> dict[str, Any]:
    key, equals, value = part.partition("=")
    known = [each for each in _READERS if each != "address" or kind == "femto-mega"]
    if key not in known:
        hint = suggestion(key, known) or f"choose from: {', '.join(known)}"
        raise UserError(f"source: {kind} has no option '{key}'; {hint}")
    try:
        if not equals:
            raise ValueError("give it a value with '='")
        return {key: _READERS[key](value)}
    except ValueError as error:
        raise UserError(f"source: {key}={value}: {error}") from error


def _number(text: str, least: float, most: float, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not least <= value <= most:
        raise ValueError(f"must be {what}, in range {least:g}..{most:g}")
    return value


def _one_of(*words: str) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in words:
            raise ValueError(f"choose from: {', '.join(words)}")
        return text

    return read


def _word(text: str) -> str:
    if not text:
        raise ValueError("must not be empty")
    return text


_READERS: dict[str, Callable[[str], Any]] = {
    "serial": _word,
    "mode": _one_of(*MODES),
    "exposure_ms": lambda text: _number(text, 0.1, 100.0, "milliseconds"),
    "gain": lambda text: round(_number(text, 0, 1000, "the device's steps")),
    "power_line_hz": lambda text: int(_one_of("50", "60")(text)),
    "sync": _one_of(*SYNCS),
    "sync_delay_us": lambda text: round(_number(text, 0, MOST_DELAY_US, "microseconds")),
    "address": _word,
}
