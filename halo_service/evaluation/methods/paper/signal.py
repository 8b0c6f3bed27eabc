"""HaloTouch's signal, to the letter (paper 4.3.1 to 4.3.4): the halo around landmark 8.

The landmarks are used as the tracker gives them; the threshold is fixed, the patch is upright.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.methods.empty_surface import Pixel, point_at
from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.profile import Background, Correction, Profile
from halo_service.sensing.correction import strength
from halo_service.values import Depth, Hand

INDEX_DISTAL, INDEX_TIP = 7, 8
"""MediaPipe's landmarks that the paper reads."""
THRESHOLD_MM = 8.0
"""Excess depth from which a pixel is halo (paper 4.3.1)."""
PATCH_WIDTH_PX, PATCH_HEIGHT_PX = 30, 20
"""Around the tip (paper 4.3.3)."""
BEYOND_PX = 15
"""How far past the tip the finger's line is followed (chosen: the halo's reach)."""
TYPICAL_PITCH_DEG = 45.0
"""Where either landmark's depth is unmeasured: the wedge's (paper 4.3.5)."""

Point = tuple[float, float, float]
Where = tuple[slice, slice] | tuple[NDArray[np.intp], NDArray[np.intp]]
"""Rows and columns of some pixels."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One index finger in one frame."""

    tip_px: Pixel
    place_mm: tuple[float, float]
    """x, y on the surface."""
    top_mm: float
    """Height at the tip's landmark; nan where unmeasured."""
    pitch_deg: float
    yaw_deg: float
    raw: float
    """Sum of the halo in the patch, mm px."""
    line_px: int
    """Halo pixels on the finger's line."""


def read(depth: Depth, hand: Hand, profile: Profile) -> Reading:
    """Read the halo around a hand's index finger."""
    tip, distal = _pixel(hand, INDEX_TIP), _pixel(hand, INDEX_DISTAL)
    camera, surface = profile.camera, profile.surface
    at_tip, at_joint = (_point(px, depth, camera, surface) for px in (tip, distal))
    pitch_deg, yaw_deg = _angles(tip, distal, at_tip, at_joint)
    x_mm, y_mm, z_mm = at_tip or point_at(tip, 0.0, camera, surface)
    return Reading(
        tip,
        (x_mm, y_mm),
        -z_mm if at_tip else math.nan,
        pitch_deg,
        yaw_deg,
        _patch_sum(depth, profile.background, tip),
        _line_pixels(depth, profile.background, tip, distal),
    )


def corrected(reading: Reading, correction: Correction | None) -> float:
    """Return the signal at the place where the states were held (paper 4.3.4)."""
    if correction is None:
        return reading.raw
    expected = strength(correction, *reading.place_mm, reading.pitch_deg, reading.yaw_deg)
    return reading.raw / expected


def _patch_sum(depth: Depth, background: Background, tip: Pixel) -> float:
    left = round(tip[0]) - PATCH_WIDTH_PX // 2
    top = round(tip[1]) - PATCH_HEIGHT_PX // 2
    rows = slice(max(top, 0), max(top + PATCH_HEIGHT_PX, 0))
    columns = slice(max(left, 0), max(left + PATCH_WIDTH_PX, 0))
    excess = _excess(depth, background, (rows, columns))
    return float(excess[excess > THRESHOLD_MM].sum())


def _line_pixels(depth: Depth, background: Background, tip: Pixel, distal: Pixel) -> int:
    """Count the halo's pixels on the line from joint to tip and on past it.

    Between the two there is finger and no halo, so to the letter (paper 4.3.6) nothing is counted.
    """
    length = max(math.dist(tip, distal), 1.0)
    share = np.arange(round(length) + BEYOND_PX) / length
    columns = np.rint(distal[0] + share * (tip[0] - distal[0])).astype(np.intp)
    rows = np.rint(distal[1] + share * (tip[1] - distal[1])).astype(np.intp)
    height, width = depth.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    excess = _excess(depth, background, (rows[inside], columns[inside]))
    return int(np.count_nonzero(excess > THRESHOLD_MM))


def _excess(depth: Depth, background: Background, where: Where) -> NDArray[np.float32]:
    """Return how much farther some pixels read than the empty surface; 0 where unmeasured."""
    seen = depth[where]
    measured = (seen > 0) & background.valid[where]
    excess = seen.astype(np.float32) - background.mean_mm[where]
    return np.where(measured, excess, np.float32(0.0))


def _point(px: Pixel, depth: Depth, camera: Camera, surface: Surface) -> Point | None:
    """Return a pixel's point in the surface's frame, mm; None where it measured nothing."""
    column, row = round(px[0]), round(px[1])
    height, width = depth.shape
    if not (0 <= row < height and 0 <= column < width) or depth[row, column] == 0:
        return None
    ray = camera.depth.rays(np.array([px]))
    x, y, z = surface.from_camera(ray * float(depth[row, column]))[0].tolist()
    return x, y, z


def _angles(
    tip: Pixel, distal: Pixel, at_tip: Point | None, at_joint: Point | None
) -> tuple[float, float]:
    """Return pitch and yaw from the landmarks' own depths."""
    if at_tip is None or at_joint is None:
        dx, dy = tip[0] - distal[0], tip[1] - distal[1]
        return TYPICAL_PITCH_DEG, math.degrees(math.atan2(dx, -dy))
    dx, dy, fall = (a - b for a, b in zip(at_tip, at_joint, strict=True))
    pitch = math.degrees(math.atan2(fall, math.hypot(dx, dy)))
    return pitch, math.degrees(math.atan2(dx, -dy))


def _pixel(hand: Hand, landmark: int) -> Pixel:
    x, y = hand.landmarks_px[landmark].tolist()
    return x, y
