"""Pictures for the page: small, grey or as the camera sent them, with what is to be drawn on them.

Rule: pure. A picture is a message: its header's length, the header as JSON, the JPEG. Every second
pixel of depth and infrared is enough for a look, and costs a quarter.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.app.page.feed import projector_corners_mm
from halo_service.geometry.camera import Camera, Lens, Points
from halo_service.profile import Profile
from halo_service.values import Depth, Frame, Touch, TouchFrame

STEP = 2
"""Every second row and column."""
QUALITY = (cv2.IMWRITE_JPEG_QUALITY, 80)
FARTHER_MM, NEARER_MM = 32.0, 100.0
"""The grey level 128 is the surface, 255 so much farther, 1 so much nearer; 0: no measurement."""
HAND_MM = 8.0
"""What is nearer than this gets an outline: more than noise."""
LEAST_OUTLINE_PX, MOST_OUTLINES = 120, 8
COLOUR_PX = 640
"""Width of a colour picture that is encoded here; a camera's JPEG goes out as it came."""
SAMPLES = 9
"""Points along each edge of an area: a lens bends it."""

Grey = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """One frame and what was sensed in it."""

    frame: Frame
    touch_frame: TouchFrame
    camera: Camera
    profile: Profile | None
    drift_mm: float = 0.0


def picture(kind: str, look: Look) -> bytes | None:
    """Return the message for `depth`, `infrared` or `colour`; None where there is none."""
    if kind == "depth":
        return _depth(look)
    if kind == "infrared":
        return _infrared(look)
    return _colour(look)


def excess_grey(depth: Depth, mean_mm: NDArray[np.float32], valid: NDArray[np.bool_]) -> Grey:
    """Return how much farther than the background each pixel reads, as `FARTHER_MM` explains."""
    excess = depth - mean_mm
    scale = np.where(excess > 0.0, np.float32(127.0 / FARTHER_MM), np.float32(127.0 / NEARER_MM))
    grey: Grey = np.clip(128.0 + excess * scale, 1.0, 255.0).astype(np.uint8)
    grey[(depth == 0) | ~valid] = 0
    return grey


@lru_cache(maxsize=1)  # all pictures of a frame share it
def _excess(look: Look) -> Grey | None:
    """Return depth as excess over the background; None without one."""
    profile, depth = look.profile, look.frame.depth
    if profile is None or profile.background.mean_mm.shape != depth.shape:
        return None
    background = profile.background
    mean_mm = background.mean_mm[::STEP, ::STEP] + np.float32(look.drift_mm)
    return excess_grey(depth[::STEP, ::STEP], mean_mm, background.valid[::STEP, ::STEP])


def _depth(look: Look) -> bytes | None:
    depth = look.frame.depth[::STEP, ::STEP]
    header: dict[str, Any] = {}
    grey = _excess(look)
    if grey is not None:
        outlines = [each.tolist() for each in _outlines(look)]
        header = {"farther_mm": FARTHER_MM, "nearer_mm": NEARER_MM, "outlines": outlines}
    else:
        seen = depth[depth > 0]
        near, far = np.percentile(seen, (2.0, 98.0)) if seen.size else (0.0, 1.0)
        span = max(float(far - near), 1.0)
        shade = np.clip(255.0 - 250.0 * (depth - np.float32(near)) / np.float32(span), 4.0, 255.0)
        grey = np.where(depth > 0, shade, 0.0).astype(np.uint8)
        header = {"from_mm": round(float(near)), "to_mm": round(float(far))}
    return _message("depth", grey, {**header, **_drawn(look, look.camera.depth, np.eye(4), STEP)})


def _infrared(look: Look) -> bytes | None:
    infrared = look.frame.ir[::STEP, ::STEP].astype(np.float32)
    bright = max(float(np.percentile(infrared[::4, ::4], 99.0)), 1.0)
    grey = np.clip(255.0 * np.sqrt(infrared / np.float32(bright)), 0.0, 255.0).astype(np.uint8)
    outlines = [each.tolist() for each in _outlines(look)]
    drawn = _drawn(look, look.camera.depth, np.eye(4), STEP)
    return _message("infrared", grey, {"outlines": outlines, **drawn})


def _colour(look: Look) -> bytes | None:
    colour, lens = look.frame.colour, look.camera.colour
    if colour is None or lens is None:
        return None
    if isinstance(colour, bytes):
        return _packed("colour", lens.width, lens.height, _in_colour(look, lens, 1.0), colour)
    shrink = colour.shape[1] / COLOUR_PX
    size = COLOUR_PX, round(colour.shape[0] / shrink)
    small = np.asarray(cv2.resize(colour, size, interpolation=cv2.INTER_NEAREST), np.uint8)
    return _message("colour", small, _in_colour(look, lens, lens.width / COLOUR_PX))


def _in_colour(look: Look, lens: Lens, shrink: float) -> dict[str, Any]:
    colour_from_depth = look.camera.colour_from_depth
    outlines = _outlines_in(look, lens, colour_from_depth, shrink)
    return {"outlines": outlines, **_drawn(look, lens, colour_from_depth, shrink)}


def _outlines_in(
    look: Look, lens: Lens, lens_from_camera: Points, shrink: float
) -> list[list[list[float]]]:
    """Return the outlines in the picture of another lens, by the depth at their pixels."""
    moved = []
    for outline in _outlines(look):
        columns, rows = outline.T
        depth = look.frame.depth[STEP * rows, STEP * columns].astype(np.float64)
        points = look.camera.depth.rays(np.asarray(STEP * outline, np.float64)) * depth[:, None]
        points = points @ lens_from_camera[:3, :3].T + lens_from_camera[:3, 3]
        moved.append(_rounded(lens.project(points), shrink))
    return moved


@lru_cache(maxsize=1)
def _outlines(look: Look) -> tuple[NDArray[np.int32], ...]:
    """Return the outlines of what is nearer than the surface, (N, 2) pixels each."""
    grey = _excess(look)
    if grey is None:
        return ()
    limit = 128.0 - HAND_MM * 127.0 / NEARER_MM
    near = ((grey > 0) & (grey < limit)).astype(np.uint8)
    found, _ = cv2.findContours(near, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    large = [each for each in found if cv2.contourArea(each) >= LEAST_OUTLINE_PX]
    large.sort(key=cv2.contourArea, reverse=True)
    thin = [cv2.approxPolyDP(each, 1.0, True) for each in large[:MOST_OUTLINES]]
    return tuple(np.asarray(each, np.int32).reshape(-1, 2) for each in thin)


def _drawn(look: Look, lens: Lens, lens_from_camera: Points, shrink: float) -> dict[str, Any]:
    """Return what is drawn on a picture: areas and fingertips, in its pixels."""
    profile = look.profile
    tips = [
        {
            "slot": pointer.slot,
            "touch": pointer.state is Touch.TOUCH,
            "at": at,
        }
        for pointer, at in zip(
            look.touch_frame.pointers, _tips(look, lens, lens_from_camera, shrink), strict=True
        )
    ]
    if profile is None:
        return {"tips": tips}
    surface = profile.surface
    width, height = surface.width_mm, surface.height_mm
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    areas = {"surface": corners, "projector": projector_corners_mm(profile)}
    return {"tips": tips} | {
        name: _rounded(surface.in_picture(_edges(area), lens, lens_from_camera), shrink)
        for name, area in areas.items()
        if area is not None
    }


def _tips(look: Look, lens: Lens, lens_from_camera: Points, shrink: float) -> list[list[float]]:
    pads = [pointer.diagnostics.camera_mm for pointer in look.touch_frame.pointers]
    points = np.array(pads, np.float64).reshape(-1, 3)
    points = points @ lens_from_camera[:3, :3].T + lens_from_camera[:3, 3]
    points[:, 2] = np.maximum(points[:, 2], 1.0)  # the test pattern has no place in the picture
    return _rounded(lens.project(points), shrink)


def _edges(corners: Points) -> Points:
    """Return points along the edges of a polygon."""
    ends = np.roll(corners, -1, axis=0)
    shares = np.linspace(0.0, 1.0, SAMPLES)[:-1, None]
    return np.concatenate([a + (b - a) * shares for a, b in zip(corners, ends, strict=True)])


def _rounded(px: Points, shrink: float) -> list[list[float]]:
    rounded: list[list[float]] = np.round(np.nan_to_num(px) / shrink, 1).tolist()
    return rounded


def _message(kind: str, image: Grey, header: dict[str, Any]) -> bytes:
    good, data = cv2.imencode(".jpg", image, QUALITY)
    assert good  # JPEG can hold any picture of bytes
    return _packed(kind, image.shape[1], image.shape[0], header, data.tobytes())


def _packed(kind: str, width: int, height: int, header: dict[str, Any], jpeg: bytes) -> bytes:
    text = json.dumps({"kind": kind, "width": width, "height": height, **header}).encode()
    return struct.pack("<I", len(text)) + text + jpeg
