"""The finger's ridge: which way its last segment points, read off many pixels of this frame.

The landmarks of tip and joint are pixels off, and two single depths give a poor pitch. So the
ridge, the part of the finger nearest to the camera, is followed back from the tip row by row,
and lines through it in space give pitch and yaw.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.sensing.finger_frame import FingerFrame, Grid, grid, nearest
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Depth

Floats = NDArray[np.float64]

BACK = np.arange(44)
"""Rows, mm behind the tip: a flat finger's last two segments."""
SIDE = np.arange(-9, 10)
"""Columns, mm from the finger's line: half a finger more than a finger."""
CREST_MM = 4.0
"""Pixels within this of a row's nearest one are ridge: a wedge under the finger is not."""
LEAST_MM = 3
"""Minimum width of a ridge row."""
LEAST_ROWS = 4
"""Minimum rows for a line."""
SEGMENT_MM = (18.0, 42.0)
"""Part for the pitch, by distance from the ridge's first point: above the halo, which bends the
last 2 cm of a low finger by up to 20 degrees, so that the pitch would follow the force instead
(chosen: over the four held states the pitch changes by 2 to 5 degrees; nearer to the tip by 10 to
14)."""
FINGER_MM = (3.0, 45.0)
"""Part for the yaw: a finger bends in one plane."""
TAPER_DEG = 6.0
"""The upper side is steeper than the axis: a finger is thinner at its end (chosen: what the virtual
hand shows at 45 degrees)."""
NAIL = grid(np.arange(-2, 3), np.arange(-2, 3))
"""Places, 1 mm apart; their mean is the height of the upper side."""
FAR = float(np.iinfo(np.uint16).max)
AT = grid(-BACK, SIDE)


class Angles(NamedTuple):
    """Of the finger's last two segments."""

    pitch_deg: float
    yaw_deg: float


def angles(
    depth: Depth,
    segmentation: Segmentation,
    place: FingerFrame,
    camera: Camera,
    surface: Surface,
) -> Angles | None:
    """Return pitch and yaw, or None where too little of the finger is measured.

    `place`: the silhouette's end.
    """
    ridge = _ridge(depth, segmentation, place)
    if ridge is None:
        return None
    px, depth_mm = ridge
    points = surface.from_camera(camera.depth.rays(px) * depth_mm[:, None])
    away_mm = np.sqrt(((points - points[0]) ** 2).sum(axis=1))
    segment = points[(away_mm >= SEGMENT_MM[0]) & (away_mm <= SEGMENT_MM[1])]
    finger = points[(away_mm >= FINGER_MM[0]) & (away_mm <= FINGER_MM[1])]
    if len(segment) < LEAST_ROWS:
        return None
    across, forward = _along(finger[:, :2])
    ahead = (segment[:, 0] * across) + (segment[:, 1] * forward)
    run, fall = _along(np.column_stack([ahead, segment[:, 2]]))
    pitch = math.degrees(math.atan2(fall, run)) - TAPER_DEG
    return Angles(pitch, math.degrees(math.atan2(across, -forward)))


def height_behind(segmentation: Segmentation, place: FingerFrame, back_mm: float) -> float:
    """Return the height of the upper side so far behind the tip, mm; nan where unmeasured.

    Relative to the empty surface in the same pixels, so that constant errors of the camera there
    cancel out.
    """
    at = Grid(NAIL.along - np.float32(back_mm), NAIL.across)
    read = nearest(segmentation.excess_mm, segmentation.within(place), at, 0.0)
    count = np.count_nonzero(read)
    return -float(read.sum()) / count if count else math.nan


def _ridge(
    depth: Depth, segmentation: Segmentation, place: FingerFrame
) -> tuple[Floats, Floats] | None:
    """Return the ridge's pixels (N, 2), tip first, and their depths (N,), mm; None if too few."""
    there = segmentation.within(place)
    read = nearest(depth[segmentation.rows, segmentation.columns], there, AT, 0.0)
    own = nearest(segmentation.hand.view(np.uint8), there, AT, 0.0)
    seen = np.where(np.logical_and(read, own), read, np.float32(FAR))
    crest = (seen <= seen.min(axis=1)[:, None] + np.float32(CREST_MM)) & (seen < FAR)
    count = np.count_nonzero(crest, axis=1)
    rows = count >= LEAST_MM
    if np.count_nonzero(rows) < LEAST_ROWS:
        return None
    crest, count, back = crest[rows], count[rows], BACK[rows]
    side = (crest @ SIDE) / count
    depth_mm = np.where(crest, seen[rows], 0.0).sum(axis=1) / count
    (x, y), (dx, dy), size = place.tip_px, place.direction, place.px_per_mm
    px = np.column_stack(
        [x - size * (back * dx + side * dy), y - size * (back * dy - side * dx)],
    )
    return px, depth_mm


def _along(points: Floats) -> tuple[float, float]:
    """Return the unit direction of a line through (N, 2) points, from the last to the first."""
    centred = points - points.mean(axis=0)
    (xx, xy), (_, yy) = (centred.T @ centred).tolist()
    turn = 0.5 * math.atan2(2.0 * xy, xx - yy)
    ux, uy = math.cos(turn), math.sin(turn)
    toward = (points[0] - points[-1]).tolist()
    sign = 1.0 if ux * toward[0] + uy * toward[1] >= 0.0 else -1.0
    return sign * ux, sign * uy
