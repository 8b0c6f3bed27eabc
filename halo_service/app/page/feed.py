"""What the page gets to see, as JSON values.

Rule: pure. Lengths are mm on the surface, values that are not known are None.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from halo_service.profile import Profile
from halo_service.runtime.health import Health
from halo_service.sensing import DEFAULT_SURFACE, State
from halo_service.values import Pointer, Touch, TouchEvent, TouchFrame

Json = dict[str, Any]
FULL_PRESS = 1.0


def frame_value(frame: TouchFrame) -> Json:
    """Return one frame with the probability of contact of each pointer, which no client gets."""
    return {
        "kind": "frame",
        "time_ms": frame.time_us // 1000,
        "pointers": [_pointer(each) for each in frame.pointers],
        "events": [_event(each) for each in frame.events],
    }


def _pointer(pointer: Pointer) -> Json:
    return {
        "id": pointer.id,
        "slot": pointer.slot,
        "side": pointer.side.name.lower(),
        "finger": pointer.finger.name.lower(),
        "touch": pointer.state is Touch.TOUCH,
        "x_mm": _number(pointer.x_mm),
        "y_mm": _number(pointer.y_mm),
        "hover_mm": _number(pointer.hover_mm),
        "pressure": _number(pointer.pressure, 3),
        "force_g": _number(pointer.force_g) if pointer.force_g >= 0.0 else None,
        "probability": _number(pointer.diagnostics.probability, 3),
        "confidence": _number(pointer.confidence, 2),
    }


def _event(event: TouchEvent) -> Json:
    return {
        "type": event.kind,
        "id": event.id,
        "slot": event.slot,
        "x_mm": _number(event.x_mm),
        "y_mm": _number(event.y_mm),
        "strike_mm_s": _number(event.strike_mm_s),
    }


def health_value(health: Health, cpu: float, fit: str, counts: Json) -> Json:
    """Return the health; `cpu`: cores that the service uses; `counts`: of clients."""
    return {
        "kind": "health",
        "fps": _number(health.fps),
        "latency_ms": _number(health.latency_ms, 2),
        "tracker_ms": _number(health.tracker_ms),
        "load": health.load,
        "looks_hz": _number(health.looks_hz),
        "drops": health.drops,
        "bad_frames": health.bad_frames,
        "tracker": health.tracker,
        "camera": health.camera,
        "cpu": _number(cpu, 2),
        "fit": fit,
        **counts,
    }


def scene_value(state: State) -> Json:
    """Return the surface, the profile and the thresholds."""
    profile, settings = state.profile, state.settings
    name, width_mm, height_mm = DEFAULT_SURFACE
    if profile is not None:
        surface = profile.surface
        name, width_mm, height_mm = surface.name, surface.width_mm, surface.height_mm
    return {
        "kind": "scene",
        "surface": name,
        "width_mm": width_mm,
        "height_mm": height_mm,
        "profile": profile.name if profile else "",
        "revision": profile.revision if profile else 0,
        "calibrated": profile.calibrated if profile else "none",
        "projector": _projector_corners(profile),
        "thresholds": {
            "down_level": settings.down_level,
            "up_level": settings.up_level,
            "hover_range_mm": settings.hover_range_mm,
            "press_g": _press_g(profile),
        },
    }


def projector_corners_mm(profile: Profile) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """Return (4, 2) where the projector's picture is on the surface, mm; None without one."""
    projector = profile.projector
    if projector is None:
        return None
    width, height = projector.width_px, projector.height_px
    corners = np.array([[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1]], np.float64)
    back = corners @ np.linalg.inv(projector.projector_from_surface).T
    return np.asarray(back[:, :2] / back[:, 2:], np.float64)


def _projector_corners(profile: Profile | None) -> list[list[float]] | None:
    corners = projector_corners_mm(profile) if profile else None
    return None if corners is None else np.round(corners, 1).tolist()


def _press_g(profile: Profile | None) -> float | None:
    """Return the force of the calibrated press; None if unknown."""
    if profile is None or profile.touch is None or profile.touch.pressure.force_g < 0.0:
        return None
    return profile.touch.pressure.force_g


def _number(value: float, digits: int = 1) -> float | None:
    return round(float(value), digits) if math.isfinite(value) else None
