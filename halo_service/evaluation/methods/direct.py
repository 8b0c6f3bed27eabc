"""The idea of DIRECT (Xiao et al. 2016): flood from the arm down to the fingertips.

Per-pixel statistics of the empty surface show what is above it. From pixels that are certainly a
hand, high above, a flood fill goes down over the lower zones; where it ends farthest away is a
fingertip, and its height, smoothed, with hysteresis, gives touch. DIRECT stops the flood at the
fingertip's edge in infrared; stored recordings hold none, so this uses depth alone, and the tip of
a touching finger, which reads as low as the surface, is cut short by some millimetres.

The height in the air is the tip's own, as coarse as depth is; there is no pressure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.methods.empty_surface import (
    EmptySurface,
    Heights,
    crop_empty_surface,
    heights,
    pixel_in,
    point_at,
)
from halo_service.evaluation.methods.pointers import (
    Published,
    Spot,
    identify,
    pointer_of,
    publish,
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
"""Pixels higher than both are above the surface (chosen: less lets noise lengthen a tip)."""
HAND_MM = 40.0
"""Higher pixels are hand or arm (chosen: a finger that touches reaches it behind its joints)."""
HAND_PX = 100
"""Fewer such pixels are no hand (chosen: a knuckle)."""
FINGER_PX = 15
"""A part that reaches less far out of the hand is no finger (chosen: a fingertip's length)."""
LEAST_PX = 12
"""Fewer pixels are none either (chosen: noise)."""
END_PX = 3.0
"""Pixels this near to a finger's farthest pixel are its tip (chosen: of 2, 3 and 5)."""
SMOOTHING = 0.4
"""Share of the new frame in the tip's height (chosen: of 0.4 to 1)."""
ENTER_MM, LEAVE_MM = 9.0, 11.0
"""A tip below this touches, and one that touches does so up to that (chosen: of 4 to 11)."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Everything that one frame passes to the next."""

    profile: Profile | None
    settings: SensingSettings
    ground: EmptySurface | None
    last: Published = field(default_factory=Published)
    height_mm: Mapping[int, float] = field(default_factory=dict)
    """Smoothed height of each tip, by its pointer's id."""
    drift: Drift = field(default_factory=Drift)


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    return State(profile, settings, crop_empty_surface(profile) if profile else None)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense one frame, without the hands."""
    del tracked
    profile, ground, settings = state.profile, state.ground, state.settings
    if profile is None or ground is None:
        return clear(state, frame.time_us)
    above = heights(ground, frame.depth, state.drift.offset_mm)
    seconds = max(frame.time_us - state.last.time_us, 1) / 1e6
    pointers: list[Pointer] = []
    smoothed: dict[int, float] = {}
    spots = tips(above, ground, profile)
    reach = (profile.surface, settings.hover_range_mm, settings.edge_margin_mm)
    for identity, spot in zip(identify(state.last, spots), spots, strict=True):
        past = state.height_mm.get(identity.id, spot.height_mm)
        height_mm = past + SMOOTHING * (spot.height_mm - past)
        touched = identity.before is not None and identity.before.state is Touch.TOUCH
        touching = height_mm < (LEAVE_MM if touched else ENTER_MM)
        shown = replace(spot, height_mm=0.0 if touching else height_mm)
        if within_reach(identity, shown, *reach):
            pointers.append(pointer_of(identity, shown, touching, profile.surface, seconds))
            smoothed[identity.id] = height_mm
    touch_frame, last = publish(state.last, pointers, frame.time_us, profile)
    drift = follow_drift(state.drift, frame.depth, profile.background, frame.time_us)
    return touch_frame, replace(state, last=last, height_mm=smoothed, drift=drift)


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Release all pointers."""
    touch_frame, last = publish(state.last, (), time_us, state.profile)
    return touch_frame, replace(state, last=last, height_mm={})


def tips(above: Heights, ground: EmptySurface, profile: Profile) -> list[Spot]:
    """Return the ends of everything that reaches out of a hand."""
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


def _spot(
    tip: tuple[float, float], height_mm: float, ground: EmptySurface, profile: Profile
) -> Spot:
    px = pixel_in(ground, *tip)
    x_mm, y_mm, _ = point_at(px, height_mm, profile.camera, profile.surface)
    return Spot((x_mm, y_mm), px, height_mm)


DIRECT = Method("direct", start, step, clear)
