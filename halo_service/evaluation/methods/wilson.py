"""Wilson 2010, "Using a depth camera as a touch sensor": pixels in a band above the surface.

Each pixel has two thresholds: nearer to the surface than `FAR_MM` it may be noise, farther than
`NEAR_MM` it is a finger in the air. What lies between is smoothed, and a patch of enough pixels
is a touch. No hand tracker, no hover and no pressure: a pointer lives while it touches, with the
least pressure and an unknown force.
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
    Identity,
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
from halo_service.values import Frame, Pointer, TouchFrame, Tracked

NEAR_MM = 10.0
"""Higher is in the air (chosen: more includes hovering flat fingers, less loses steep ones)."""
FAR_MM = 2.0
FAR_SIGMAS = 4.0
"""Lower than either may be the surface's own noise (chosen: twice and four times it)."""
SMOOTH_PX = 3
"""Side of the box over which the band is averaged (chosen: a larger one loses steep fingers)."""
ENTER_PX, LEAVE_PX = 14, 7
"""Pixels of a patch that begin a touch, and that continue it (chosen: see above)."""
MISSED_FRAMES = 2
"""A touch survives this many frames without its patch (chosen: patches flicker for 1 or 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Everything that one frame passes to the next."""

    profile: Profile | None
    settings: SensingSettings
    ground: EmptySurface | None
    last: Published = field(default_factory=Published)
    missed: Mapping[int, int] = field(default_factory=dict)
    """Frames since a pointer's patch was last seen, by its id."""
    drift: Drift = field(default_factory=Drift)


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    return State(profile, settings, crop_empty_surface(profile) if profile else None)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense one frame, without the hands."""
    del tracked
    profile, ground = state.profile, state.ground
    if profile is None or ground is None:
        return clear(state, frame.time_us)
    above = heights(ground, frame.depth, state.drift.offset_mm)
    seconds = max(frame.time_us - state.last.time_us, 1) / 1e6
    pointers: list[Pointer] = []
    missed: dict[int, int] = {}
    found = patches(above, ground, profile)
    spots = [spot for spot, _ in found]
    for identity, (spot, size) in zip(identify(state.last, spots), found, strict=True):
        if size >= (ENTER_PX if identity.before is None else LEAVE_PX) and _near(
            identity, spot, state
        ):
            pointers.append(pointer_of(identity, spot, True, profile.surface, seconds))
            missed[identity.id] = 0
    for pointer in state.last.pointers:
        if pointer.id not in missed and state.missed[pointer.id] < MISSED_FRAMES:
            pointers.append(pointer)
            missed[pointer.id] = state.missed[pointer.id] + 1
    touch_frame, last = publish(state.last, pointers, frame.time_us, profile)
    drift = follow_drift(state.drift, frame.depth, profile.background, frame.time_us)
    return touch_frame, replace(state, last=last, missed=missed, drift=drift)


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Release all pointers."""
    touch_frame, last = publish(state.last, (), time_us, state.profile)
    return touch_frame, replace(state, last=last, missed={})


def patches(above: Heights, ground: EmptySurface, profile: Profile) -> list[tuple[Spot, int]]:
    """Return the patches in the band, largest first, with their size in pixels."""
    far = np.maximum(np.float32(FAR_MM), np.float32(FAR_SIGMAS) * ground.noise_mm)
    band = ((above > far) & (above < NEAR_MM)).astype(np.uint8)
    smooth = cv2.blur(band * np.uint8(255), (SMOOTH_PX, SMOOTH_PX))
    _, _, stats, middles = cv2.connectedComponentsWithStats((smooth > 127).astype(np.uint8))
    sizes = stats[:, cv2.CC_STAT_AREA]
    order = [each for each in np.argsort(-sizes).tolist() if each and sizes[each] >= LEAVE_PX]
    return [(_spot(middles[each], ground, profile), int(sizes[each])) for each in order]


def _spot(middle: NDArray[np.float64], ground: EmptySurface, profile: Profile) -> Spot:
    px = pixel_in(ground, float(middle[0]), float(middle[1]))
    x_mm, y_mm, _ = point_at(px, 0.0, profile.camera, profile.surface)
    return Spot((x_mm, y_mm), px, 0.0)


def _near(identity: Identity, spot: Spot, state: State) -> bool:
    assert state.profile is not None  # nothing is found without one
    settings = state.settings
    surface = state.profile.surface
    return within_reach(identity, spot, surface, settings.hover_range_mm, settings.edge_margin_mm)


WILSON = Method("wilson", start, step, clear)
