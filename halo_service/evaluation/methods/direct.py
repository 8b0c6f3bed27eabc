"""The idea of DIRECT (Xiao et al. 2016): flood from the arm down to the fingertips.

Per-pixel statistics of the empty surface tell what stands above it. From what is surely a hand,
high above, one floods down over the lower zones; where the flood ends farthest away is a
fingertip, and its height, smoothed, with hysteresis, tells touch. DIRECT stops the flood at the
fingertip's edge in infrared; the bench keeps none, so depth alone must do here, and the tip of a
touching finger, which reads as low as the surface, is cut short by some millimetres.

The height in the air is the tip's own, as coarse as depth is; there is no pressure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.methods.empty_surface import (
    Ground,
    Heights,
    ground_of,
    heights,
    pixel_in,
    point_at,
)
from halo_service.evaluation.methods.pointers import (
    Spot,
    Told,
    pointer_of,
    recognised,
    tell,
    within_reach,
)
from halo_service.profile import Profile
from halo_service.runtime.method import Method
from halo_service.sensing import SensingSettings
from halo_service.sensing.background import Drift, follow_drift
from halo_service.values import Frame, Pointer, Touch, TouchFrame, Tracked

Mask = NDArray[np.bool_]

SOLID_SIGMAS = 4.0
SOLID_MM = 3.0
"""What is higher than both stands on the surface (chosen: lower ones let noise lengthen a tip)."""
HAND_MM = 40.0
"""What is higher is hand or arm (chosen: a finger that touches reaches it behind its joints)."""
HAND_PX = 100
"""Fewer such pixels are no hand (chosen: a knuckle)."""
FINGER_PX = 15
"""What reaches less far out of the hand is no finger (chosen: a fingertip's length)."""
LEAST_PX = 12
"""Fewer pixels are none either (chosen: noise)."""
END_PX = 3.0
"""What lies within so much of a finger's farthest pixel is its tip (chosen: of 2, 3 and 5)."""
SMOOTHING = 0.4
"""Share of the new frame in the tip's height (chosen: of 0.4 to 1)."""
ENTER_MM, LEAVE_MM = 9.0, 11.0
"""A tip below this touches, and one that touches does so up to that (chosen: of 4 to 11)."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All that one frame leaves to the next."""

    profile: Profile | None
    settings: SensingSettings
    ground: Ground | None
    told: Told = field(default_factory=Told)
    height_mm: Mapping[int, float] = field(default_factory=dict)
    """Smoothed height of each tip, by its pointer's id."""
    drift: Drift = field(default_factory=Drift)


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    return State(profile, settings, ground_of(profile) if profile else None)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense one frame; the hands are not looked at."""
    del tracked
    profile, ground, settings = state.profile, state.ground, state.settings
    if profile is None or ground is None:
        return clear(state, frame.time_us)
    above = heights(ground, frame.depth, state.drift.offset_mm)
    seconds = max(frame.time_us - state.told.time_us, 1) / 1e6
    pointers: list[Pointer] = []
    smoothed: dict[int, float] = {}
    spots = tips(above, ground, profile)
    reach = (profile.surface, settings.hover_range_mm, settings.edge_margin_mm)
    for known, spot in zip(recognised(state.told, spots), spots, strict=True):
        past = state.height_mm.get(known.id, spot.height_mm)
        height_mm = past + SMOOTHING * (spot.height_mm - past)
        touched = known.before is not None and known.before.state is Touch.TOUCH
        touching = height_mm < (LEAVE_MM if touched else ENTER_MM)
        told_spot = replace(spot, height_mm=0.0 if touching else height_mm)
        if within_reach(known, told_spot, *reach):
            pointers.append(pointer_of(known, told_spot, touching, profile.surface, seconds))
            smoothed[known.id] = height_mm
    frame_told, told = tell(state.told, pointers, frame.time_us, profile)
    drift = follow_drift(state.drift, frame.depth, profile.background, frame.time_us)
    return frame_told, replace(state, told=told, height_mm=smoothed, drift=drift)


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Let all pointers go."""
    frame_told, told = tell(state.told, (), time_us, state.profile)
    return frame_told, replace(state, told=told, height_mm={})


def tips(above: Heights, ground: Ground, profile: Profile) -> list[Spot]:
    """Return the ends of all that reaches out of a hand."""
    least = np.maximum(np.float32(SOLID_MM), np.float32(SOLID_SIGMAS) * ground.noise_mm)
    hand = _large(above > HAND_MM, HAND_PX)
    if not hand.any():
        return []
    away = cv2.distanceTransform((~hand).astype(np.uint8), cv2.DIST_L2, 3)
    out = ((above > least) & ~hand).astype(np.uint8)
    opened = cv2.morphologyEx(out, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(opened)
    spots = []
    for label in range(1, count):
        left, top, width, height, size = stats[label].tolist()
        if size < LEAST_PX:
            continue
        box = np.s_[top : top + height, left : left + width]
        mine = labels[box] == label
        far = away[box][mine]
        rooted = far.min() < 2.0
        if rooted and far.max() >= FINGER_PX:
            rows, columns = np.nonzero(mine)
            end = far > far.max() - END_PX
            tip = (left + float(columns[end].mean()), top + float(rows[end].mean()))
            spots.append(_spot(tip, float(above[box][mine][end].mean()), ground, profile))
    return spots


def _large(mask: Mask, least_px: int) -> Mask:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    keep = stats[:, cv2.CC_STAT_AREA] >= least_px
    keep[0] = False
    return np.asarray(keep[labels])


def _spot(tip: tuple[float, float], height_mm: float, ground: Ground, profile: Profile) -> Spot:
    px = pixel_in(ground, *tip)
    x_mm, y_mm, _ = point_at(px, height_mm, profile.camera, profile.surface)
    return Spot((x_mm, y_mm), px, height_mm)


DIRECT = Method("direct", start, step, clear)
