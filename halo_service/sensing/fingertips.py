"""Stage 3: fingertips, carried forward from the tracker's frame to the present one.

The hand tracker is late by a frame or more and its landmarks are some pixels off. So each tip
is moved by what the same finger has done since, then put on the end of the finger's silhouette
in the present depth frame.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.profile import Profile
from halo_service.sensing.revealer import Revealed
from halo_service.sensing.ridge import angles
from halo_service.sensing.sightings import Pixel, Sighting
from halo_service.values import Depth, Fingertip

PAD_BACK_MM = 7.0
"""The pad's lowest point lies this far behind the silhouette's end (chosen: half a fingertip)."""
ROI_PX = 22
"""Half the window in which the silhouette is sought: a fast finger's way in one frame."""
HALF_WIDTH_PX = 9.0
"""Half a finger's width at 0.5 m, px."""
LEAST_HAND_PX = 20
"""Fewer hand pixels in the window are noise."""
PAD_REACH_PX = 1
"""The nail is read off the median of 3 x 3 pixels."""
UNSEEN_CONFIDENCE = 0.4
"""Factor for a tip that the present frame does not show."""
VALID_PITCH_DEG = (15.0, 75.0)
"""Between these the paper's halo is reliable (paper 4.3.4)."""
STEEP_CONFIDENCE = 0.5
"""Factor for pitches outside of it."""
TYPICAL_PITCH_DEG = 45.0
"""Assumed where the finger's depth is unmeasured: the paper's wedge (paper 4.3.5)."""


def locate(
    sighting: Sighting,
    moved_px: Pixel,
    revealed: Revealed,
    depth: Depth,
    profile: Profile,
    thickness_mm: float,
) -> Fingertip:
    """Find a sighted tip in the present frame.

    `moved_px`: how far this finger's tip has gone since the tracker's frame, as far as known.
    """
    camera, surface = profile.camera, profile.surface
    direction = _unit(sighting.distal_px, sighting.tip_px)
    guess = (sighting.tip_px[0] + moved_px[0], sighting.tip_px[1] + moved_px[1])
    seen = silhouette_end(revealed.hand, guess, direction)
    tip = seen or guess
    shift = (tip[0] - sighting.tip_px[0], tip[1] - sighting.tip_px[1])
    distal = (sighting.distal_px[0] + shift[0], sighting.distal_px[1] + shift[1])

    pad, top_mm = _pad(tip, direction, depth, camera, surface, thickness_mm)
    read = angles(depth, revealed.hand, tip, direction, camera, surface)
    pitch, yaw = read or (TYPICAL_PITCH_DEG, math.degrees(math.atan2(direction[0], -direction[1])))
    height = 0.0 if math.isnan(top_mm) else max(top_mm - thickness_mm, 0.0)
    camera_mm = surface.to_camera(np.array([[pad[0], pad[1], -height]]))[0]
    confidence = sighting.confidence * (1.0 if seen else UNSEEN_CONFIDENCE)
    if not VALID_PITCH_DEG[0] <= pitch <= VALID_PITCH_DEG[1]:
        confidence *= STEEP_CONFIDENCE
    return Fingertip(
        sighting.side,
        sighting.finger,
        tip,
        distal,
        pad,
        (float(camera_mm[0]), float(camera_mm[1]), float(camera_mm[2])),
        top_mm,
        pitch,
        yaw,
        confidence,
    )


def silhouette_end(hand: NDArray[np.bool_], guess: Pixel, direction: Pixel) -> Pixel | None:
    """Return the end of the finger's silhouette near a guess, or None where no finger is.

    `hand`: (H, W) mask; `direction`: unit vector from joint to tip.
    """
    tip = guess
    for _ in range(2):  # the second pass looks straight along the finger, the first may look askew
        left, top = round(tip[0]) - ROI_PX, round(tip[1]) - ROI_PX
        window = hand[
            max(top, 0) : max(top + 2 * ROI_PX, 0), max(left, 0) : max(left + 2 * ROI_PX, 0)
        ]
        rows, columns = np.nonzero(window)
        dx, dy = columns + max(left, 0) - tip[0], rows + max(top, 0) - tip[1]
        along = dx * direction[0] + dy * direction[1]
        across = dy * direction[0] - dx * direction[1]
        finger = np.abs(across) <= HALF_WIDTH_PX
        if np.count_nonzero(finger) < LEAST_HAND_PX:
            return None
        along, across = along[finger], across[finger]
        end = float(np.partition(along, -3)[-3])  # the third farthest: two may be stray pixels
        middle = float(across[along > end - HALF_WIDTH_PX].mean())
        tip = (
            tip[0] + end * direction[0] - middle * direction[1],
            tip[1] + end * direction[1] + middle * direction[0],
        )
    return tip


def _pad(
    tip: Pixel,
    direction: Pixel,
    depth: Depth,
    camera: Camera,
    surface: Surface,
    thickness_mm: float,
) -> tuple[tuple[float, float], float]:
    """Return the pad's x, y on the surface and the height of the finger's upper side above it."""
    distance_mm = float(surface.camera_from_surface[2, 3])
    back_px = PAD_BACK_MM * camera.depth.fx / max(distance_mm, 1.0)
    above = (tip[0] - back_px * direction[0], tip[1] - back_px * direction[1])
    seen = _on_surface(above, depth, camera, surface)
    if seen is not None:
        return (float(seen[0]), float(seen[1])), float(-seen[2])
    ray = camera.depth.rays(np.array([above]))[0]
    rotation, origin = surface.camera_from_surface[:3, :3], surface.camera_from_surface[:3, 3]
    normal = rotation[:, 2]
    scale = (normal @ origin - thickness_mm) / (normal @ ray)
    x, y, _ = surface.from_camera((ray * scale)[None])[0]
    return (float(x), float(y)), math.nan


def _on_surface(
    px: Pixel, depth: Depth, camera: Camera, surface: Surface
) -> NDArray[np.float64] | None:
    """Return what a pixel and those beside it see in the surface's frame, mm, or None."""
    column, row = round(px[0]), round(px[1])
    near = depth[
        max(row - PAD_REACH_PX, 0) : max(row + PAD_REACH_PX + 1, 0),
        max(column - PAD_REACH_PX, 0) : max(column + PAD_REACH_PX + 1, 0),
    ]
    measured = np.sort(near[near > 0])
    if measured.size == 0:
        return None
    ray = camera.depth.rays(np.array([px]))
    depth_mm = float(measured[(measured.size - 1) // 2])
    return np.asarray(surface.from_camera(ray * depth_mm)[0])


def _unit(start: Pixel, end: Pixel) -> Pixel:
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    return (dx / length, dy / length) if length > 0.0 else (0.0, -1.0)
