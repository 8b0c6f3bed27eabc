"""What all rivals need besides their idea: which finger is which, and how to publish it.

Ids by nearest neighbour; events are the difference between the last pointers and the new ones, so
that a touch is reported once and always ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from halo_service.geometry.surface import Surface
from halo_service.profile import Profile
from halo_service.sensing import DEFAULT_SURFACE
from halo_service.values import (
    Diagnostics,
    Finger,
    Pointer,
    Side,
    Touch,
    TouchEvent,
    TouchFrame,
)

SAME_FINGER_MM = 80.0
"""A finger farther away than this is another one."""
RANGE_HYSTERESIS_MM = 5.0
"""A live pointer may go this much farther than a new one may come in."""
MOST_SLOTS = 10
"""Slots run from 0 to 9: two hands."""
LEAST_PRESSURE = 0.02
"""Of a touch where the pressure is unknown."""
UNKNOWN = math.nan


@dataclass(frozen=True, slots=True)
class Spot:
    """One finger in one frame, as a rival measures it."""

    place_mm: tuple[float, float]
    """x, y on the surface."""
    tip_px: tuple[float, float]
    height_mm: float
    """Above the surface, as far as the rival knows; 0 in touch."""
    side: Side = Side.UNKNOWN
    finger: Finger = Finger.INDEX
    confidence: float = 1.0
    pitch_deg: float = UNKNOWN
    yaw_deg: float = UNKNOWN
    halo: float = UNKNOWN
    halo_corrected: float = UNKNOWN
    level: float = UNKNOWN


@dataclass(frozen=True, slots=True)
class Identity:
    """Which pointer a spot belongs to."""

    id: int
    slot: int
    before: Pointer | None
    """As last published; None for a new one."""


@dataclass(frozen=True, slots=True)
class Published:
    """The last pointers, and the next id."""

    pointers: tuple[Pointer, ...] = ()
    time_us: int = 0
    next_id: int = 1


def identify(last: Published, spots: Sequence[Spot]) -> list[Identity]:
    """Match each spot with the nearest live pointer, or make it a new one."""
    pairs = sorted(
        (distance, i, j)
        for i, pointer in enumerate(last.pointers)
        for j, spot in enumerate(spots)
        if (distance := math.dist((pointer.x_mm, pointer.y_mm), spot.place_mm)) < SAME_FINGER_MM
    )
    owner: dict[int, int] = {}
    for _, i, j in pairs:
        if j not in owner and i not in owner.values():
            owner[j] = i
    ids = count(last.next_id)
    slots = (slot for slot in count() if slot not in {each.slot for each in last.pointers})
    found = []
    for j in range(len(spots)):
        before = last.pointers[owner[j]] if j in owner else None
        fresh = (next(ids), next(slots)) if before is None else (before.id, before.slot)
        found.append(Identity(*fresh, before))
    return found


def pointer_of(
    identity: Identity,
    spot: Spot,
    touching: bool,
    surface: Surface,
    seconds: float,
    pressure: float = LEAST_PRESSURE,
    force_g: float = -1.0,
) -> Pointer:
    """Return the pointer of a finger. `seconds`: since it was published last."""
    before, (x_mm, y_mm) = identity.before, spot.place_mm
    came_down = touching and (before is None or before.state is Touch.HOVER)
    moved = (x_mm - before.x_mm, y_mm - before.y_mm) if before else (0.0, 0.0)
    point = np.array([[x_mm, y_mm, -spot.height_mm]])
    camera_x, camera_y, camera_z = surface.to_camera(point)[0].tolist()
    return Pointer(
        id=identity.id,
        slot=identity.slot,
        side=spot.side,
        finger=spot.finger,
        state=Touch.TOUCH if touching else Touch.HOVER,
        x_mm=x_mm,
        y_mm=y_mm,
        hover_mm=0.0 if touching else spot.height_mm,
        pressure=pressure if touching else 0.0,
        force_g=force_g,
        vx_mm_s=moved[0] / seconds,
        vy_mm_s=moved[1] / seconds,
        confidence=spot.confidence,
        contacts=(before.contacts if before else 0) + came_down,
        diagnostics=Diagnostics(
            camera_mm=(camera_x, camera_y, camera_z),
            tip_px=spot.tip_px,
            halo=spot.halo,
            halo_corrected=spot.halo_corrected,
            level=spot.level,
            top_mm=UNKNOWN,
            pitch_deg=spot.pitch_deg,
            yaw_deg=spot.yaw_deg,
        ),
    )


def within_reach(
    identity: Identity, spot: Spot, surface: Surface, range_mm: float, edge: float
) -> bool:
    """Whether a spot is near enough to the surface and its edges to be a pointer."""
    slack = 0.0 if identity.before is None else RANGE_HYSTERESIS_MM
    x_mm, y_mm = spot.place_mm
    return (
        identity.slot < MOST_SLOTS
        and spot.height_mm <= range_mm + slack
        and -edge - slack <= x_mm <= surface.width_mm + edge + slack
        and -edge - slack <= y_mm <= surface.height_mm + edge + slack
    )


def publish(
    last: Published,
    pointers: Sequence[Pointer],
    time_us: int,
    profile: Profile | None,
    ago_ms: float = 0.0,
) -> tuple[TouchFrame, Published]:
    """Publish the new pointers. `ago_ms`: age of the frame that shows them."""
    past = {pointer.id: pointer for pointer in last.pointers}
    now = {pointer.id: pointer for pointer in pointers}
    events = [
        event
        for each in {**past, **now}
        if (event := _change(past.get(each), now.get(each), ago_ms)) is not None
    ]
    surface = profile.surface if profile else None
    shown = (surface.name, surface.width_mm, surface.height_mm) if surface else DEFAULT_SURFACE
    frame = TouchFrame(time_us, *shown, tuple(pointers), tuple(events))
    return frame, replace(
        last,
        pointers=tuple(pointers),
        time_us=time_us,
        next_id=max([last.next_id, *(each + 1 for each in now)]),
    )


def _change(past: Pointer | None, now: Pointer | None, ago_ms: float) -> TouchEvent | None:
    touched = past is not None and past.state is Touch.TOUCH
    touches = now is not None and now.state is Touch.TOUCH
    shown = now or past
    if touched == touches or shown is None:
        return None
    return TouchEvent(
        kind="down" if touches else "up",
        id=shown.id,
        slot=shown.slot,
        x_mm=shown.x_mm,
        y_mm=shown.y_mm,
        strike_mm_s=0.0,  # no rival measures the strike
        ago_ms=ago_ms,
        contacts=shown.contacts,
    )
