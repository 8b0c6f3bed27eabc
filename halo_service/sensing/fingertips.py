"""Stage 3: fingertips, located in the present frame.

The hand tracker is late by a frame or more and its landmarks are some pixels off; `tracks` predicts
how far a tip has moved since. Here the tip is moved to the end of the finger's outline in the
present depth frame. The pad is under the middle of that round end.
"""

from __future__ import annotations

import math

import numpy as np

from halo_service.geometry.camera import Points
from halo_service.geometry.surface import Surface, line_of_sight_deg
from halo_service.profile import Profile
from halo_service.sensing.detections import Detection
from halo_service.sensing.finger_frame import FingerFrame, unit
from halo_service.sensing.outline import Outline, outline
from halo_service.sensing.ridge import angles, height_behind
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Depth, Fingertip

NAIL_MM = 4.0
"""The upper side's height is read so far behind the outline's end: on the nail, and not yet at the
edge (chosen; farther back it depends more on the pitch). The same for every finger: the calibration
does not know a finger's radius yet, and a millimetre farther back is a millimetre higher."""
OBLIQUE_MM = 10.0
"""How much higher that is for each unit of the cotangent of the angle between the finger and the
line of sight: where the camera looks along a finger, the same place in the image lies farther back
on it (measured on virtual users without long nails: 8 to 14; for a round end it is 2, and the rest
is the finger's end that the halo takes)."""
LEAST_SEEN_DEG = 12.0
"""For a smaller angle, from either end, that is not followed any farther."""
TIP_RADIUS_MM = 7.0
"""Of a fingertip, if none was measured (chosen: half an adult's index finger)."""
UNSEEN_CONFIDENCE = 0.4
"""Factor for a tip that the present frame does not show."""
UNCLEAR_CONFIDENCE = 0.7
"""Factor for a tip without a clear edge."""
VALID_PITCH_DEG = (15.0, 75.0)
"""Between these the paper's halo is reliable (paper 4.3.4)."""
STEEP_CONFIDENCE = 0.5
"""Factor for pitches outside of it."""
TYPICAL_PITCH_DEG = 45.0
"""Assumed where the finger's depth is unmeasured: the paper's wedge (paper 4.3.5)."""


def locate(
    detection: Detection,
    segmentation: Segmentation,
    depth: Depth,
    profile: Profile,
    thickness_mm: float,
    radius_mm: float = TIP_RADIUS_MM,
) -> Fingertip:
    """Find a detected tip in the present frame.

    `detection`: moved to its predicted place;
    `thickness_mm`, `radius_mm`: of the fingertip, from pad to nail and from side to middle.
    """
    camera, surface = profile.camera, profile.surface
    guess = FingerFrame(
        detection.tip_px, unit(detection.distal_px, detection.tip_px), detection.px_per_mm
    )
    seen = outline(segmentation, depth, guess, radius_mm)
    end = seen or Outline(guess, math.nan, False)
    tip, direction, px_per_mm = end.place
    back_px = math.dist(detection.distal_px, detection.tip_px)
    distal = end.place.moved(-back_px / px_per_mm).tip_px

    read = angles(depth, segmentation, end.place, camera, surface)
    pitch, yaw = read or (TYPICAL_PITCH_DEG, math.degrees(math.atan2(direction[0], -direction[1])))
    rays = camera.depth.rays(np.array([tip, distal]))
    sight = tuple(rays[0].tolist())
    seen_deg = line_of_sight_deg(sight, pitch, yaw, surface) if read else math.nan
    top_mm = height_behind(segmentation, end.place, NAIL_MM)
    height = 0.0 if math.isnan(top_mm) else max(top_mm - thickness_mm, 0.0)
    pad = _pad(rays, surface, height + radius_mm, radius_mm)
    camera_mm = surface.to_camera(np.array([[pad[0], pad[1], -height]]))[0]
    confidence = detection.confidence
    if not end.clear:
        confidence *= UNCLEAR_CONFIDENCE if seen else UNSEEN_CONFIDENCE
    if not VALID_PITCH_DEG[0] <= pitch <= VALID_PITCH_DEG[1]:
        confidence *= STEEP_CONFIDENCE
    return Fingertip(
        detection.side,
        detection.finger,
        tip,
        distal,
        pad,
        (float(camera_mm[0]), float(camera_mm[1]), float(camera_mm[2])),
        top_mm,
        pitch,
        yaw,
        confidence,
        end.width_mm,
        px_per_mm,
        seen_deg,
    )


def oblique(seen_deg: float) -> float:
    """Return the cotangent of the angle between a finger and the line of sight.

    1 where the angle was not measured: most fingers are seen under about 45 degrees.
    """
    if math.isnan(seen_deg):
        return 1.0
    bounded = min(max(seen_deg, LEAST_SEEN_DEG), 180.0 - LEAST_SEEN_DEG)
    return 1.0 / math.tan(math.radians(bounded))


def plain_top_mm(top_mm: float, seen_deg: float) -> float:
    """Return how high an upper side would read at 45 degrees to the line of sight."""
    return top_mm - OBLIQUE_MM * (oblique(seen_deg) - 1.0)


def _pad(rays: Points, surface: Surface, height_mm: float, radius_mm: float) -> tuple[float, float]:
    """Return the pad's x, y on the surface.

    `rays`: (2, 3) through the outline's end and through a point behind it; `height_mm`: of the
    round tip's middle, where a camera sees its outline. Its lowest point lies under that middle,
    at any pitch of the finger.
    """
    rotation, origin = surface.camera_from_surface[:3, :3], surface.camera_from_surface[:3, 3]
    normal = rotation[:, 2]
    reach = (normal @ origin - height_mm) / (rays @ normal)
    end, behind = surface.from_camera(rays * reach[:, None])[:, :2]
    back = (behind - end) / max(float(np.linalg.norm(behind - end)), 1e-6)
    x, y = end + radius_mm * back
    return float(x), float(y)
