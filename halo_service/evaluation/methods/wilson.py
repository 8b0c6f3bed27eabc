"""Wilson 2010, "Using a depth camera as a touch sensor": what lies in a band above the surface.

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
    Ground,
    Heights,
    ground_of,
    heights,
    pixel_in,
    point_at,
)
from halo_service.evaluation.methods.pointers import (
    Known,
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
from halo_service.values import Frame, Pointer, TouchFrame, Tracked

NEAR_MM = 10.0
"""What is higher is in the air (chosen: more sees flat fingers that hover, less no steep ones)."""
FAR_MM = 2.0
FAR_SIGMAS = 4.0
"""What is lower than either may be the surface's own noise (chosen: twice and four times it)."""
SMOOTH_PX = 3
"""Side of the box over which the band is averaged (chosen: a larger one loses steep fingers)."""
ENTER_PX, LEAVE_PX = 14, 7
"""A patch of so many pixels begins a touch, and of so many keeps it (chosen: see above)."""
MISSED_FRAMES = 2
"""A touch outlives so many frames without its patch (chosen: patches flicker for one or two)."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All that one frame leaves to the next."""

    profile: Profile | None
    settings: SensingSettings
    ground: Ground | None
    told: Told = field(default_factory=Told)
    missed: Mapping[int, int] = field(default_factory=dict)
    """Frames since a pointer's patch was last seen, by its id."""
    drift: Drift = field(default_factory=Drift)


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    return State(profile, settings, ground_of(profile) if profile else None)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense one frame; the hands are not looked at."""
    del tracked
    profile, ground = state.profile, state.ground
    if profile is None or ground is None:
        return clear(state, frame.time_us)
    above = heights(ground, frame.depth, state.drift.offset_mm)
    seconds = max(frame.time_us - state.told.time_us, 1) / 1e6
    pointers: list[Pointer] = []
    missed: dict[int, int] = {}
    found = patches(above, ground, profile)
    spots = [spot for spot, _ in found]
    for known, (spot, size) in zip(recognised(state.told, spots), found, strict=True):
        if size >= (ENTER_PX if known.before is None else LEAVE_PX) and _near(known, spot, state):
            pointers.append(pointer_of(known, spot, True, profile.surface, seconds))
            missed[known.id] = 0
    for pointer in state.told.pointers:
        if pointer.id not in missed and state.missed[pointer.id] < MISSED_FRAMES:
            pointers.append(pointer)
            missed[pointer.id] = state.missed[pointer.id] + 1
    frame_told, told = tell(state.told, pointers, frame.time_us, profile)
    drift = follow_drift(state.drift, frame.depth, profile.background, frame.time_us)
    return frame_told, replace(state, told=told, missed=missed, drift=drift)


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Let all pointers go."""
    frame_told, told = tell(state.told, (), time_us, state.profile)
    return frame_told, replace(state, told=told, missed={})


def patches(above: Heights, ground: Ground, profile: Profile) -> list[tuple[Spot, int]]:
    """Return what lies in the band, largest first, with its size in pixels."""
    far = np.maximum(np.float32(FAR_MM), np.float32(FAR_SIGMAS) * ground.noise_mm)
    band = ((above > far) & (above < NEAR_MM)).astype(np.uint8)
    smooth = cv2.blur(band * np.uint8(255), (SMOOTH_PX, SMOOTH_PX))
    _, _, stats, middles = cv2.connectedComponentsWithStats((smooth > 127).astype(np.uint8))
    sizes = stats[:, cv2.CC_STAT_AREA]
    order = [each for each in np.argsort(-sizes).tolist() if each and sizes[each] >= LEAVE_PX]
    return [(_spot(middles[each], ground, profile), int(sizes[each])) for each in order]


def _spot(middle: NDArray[np.float64], ground: Ground, profile: Profile) -> Spot:
    px = pixel_in(ground, float(middle[0]), float(middle[1]))
    x_mm, y_mm, _ = point_at(px, 0.0, profile.camera, profile.surface)
    return Spot((x_mm, y_mm), px, 0.0)


def _near(known: Known, spot: Spot, state: State) -> bool:
    assert state.profile is not None  # nothing is found without one
    settings = state.settings
    surface = state.profile.surface
    return within_reach(known, spot, surface, settings.hover_range_mm, settings.edge_margin_mm)


WILSON = Method("wilson", start, step, clear)
