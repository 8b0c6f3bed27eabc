"""The truth, line by line, next to the frames and never in them.

Rule: for the evaluation and the recorder's truth file only; no frame contains it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.values import Finger, Side
from halo_service.virtual.mesh import Floats
from halo_service.virtual.motion import Contact, Step
from halo_service.virtual.skeleton import PosedHand

Line = dict[str, Any]


def frame_line(time_us: int, camera: Camera, surface: Surface, hands: Sequence[PosedHand]) -> Line:
    """The truth of one depth frame: every pointing finger whose tip is in the image."""
    fingers = [
        _finger(surface, hand, finger)
        for hand in hands
        for finger in Finger
        if hand.pointing(finger) and _in_view(camera, surface, hand.pad(finger))
    ]
    return {"time_us": time_us, "fingers": fingers}


def _in_view(camera: Camera, surface: Surface, point: Floats) -> bool:
    x, y = camera.depth.project(surface.to_camera(point[None]))[0]
    return bool(0.0 <= x < camera.depth.width and 0.0 <= y < camera.depth.height)


def _finger(surface: Surface, hand: PosedHand, finger: Finger) -> Line:
    pad = hand.pad(finger)
    force = hand.force_g[finger]
    pad[2] = min(float(pad[2]), 0.0)  # a pressed pad is flat: its lowest point lies on the surface
    pitch, yaw = hand.pitch_yaw(finger)
    return {
        "hand": side_name(hand.side),
        "finger": finger.name.lower(),
        "camera_mm": _rounded(surface.to_camera(pad[None])[0]),
        "height_mm": round(float(-pad[2]), 3) + 0.0,
        "touching": force > 0.0,
        "force_g": round(force, 2),
        "pitch_deg": round(pitch, 2),
        "yaw_deg": round(yaw, 2),
    }


def contact_line(contact: Contact, surface: Surface, frame_us: Callable[[float], int]) -> Line:
    """The truth of one touch; `frame_us` maps seconds of the scenario to the frames' clock."""
    place = surface.to_camera(np.array([[contact.x_mm, contact.y_mm, 0.0]]))[0]
    line: Line = {
        "hand": side_name(contact.side),
        "finger": contact.finger.name.lower(),
        "from_us": frame_us(contact.from_s),
        "to_us": frame_us(contact.to_s),
        "camera_mm": _rounded(place),
        "strike_mm_s": round(contact.strike_mm_s, 1),
        "peak_force_g": round(contact.peak_force_g, 1),
    }
    if contact.target_mm is not None:
        line["target_mm"] = [round(v, 2) for v in contact.target_mm]
    if contact.key is not None:
        line["key"] = contact.key
    return {"contact": line}


def step_line(step: Step, frame_s: Callable[[float], float]) -> Line:
    """One step of a script; `frame_s` maps seconds of the scenario to those of the frames."""
    times = {"from_s": round(frame_s(step.from_s), 3), "to_s": round(frame_s(step.to_s), 3)}
    return {"step": step.name, **times, **step.fields}


def side_name(side: Side) -> str:
    """As the files write it."""
    return side.name.lower()


def _rounded(values: Any) -> list[float]:
    return [round(float(v), 3) for v in values]
