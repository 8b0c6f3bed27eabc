"""From a sensed finger to what clients are told of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from halo_service.geometry.surface import Surface
from halo_service.profile import TouchStates
from halo_service.sensing.hover import hover_height
from halo_service.sensing.pressure import FORCE_UNKNOWN_G, force, touch_pressure
from halo_service.sensing.settings import SensingSettings
from halo_service.values import (
    Contact,
    Diagnostics,
    Fingertip,
    Pointer,
    Signal,
    Touch,
)

SMOOTHING_MS = 50.0
"""Time constant of a pointer's velocity (chosen: two frames)."""
RANGE_HYSTERESIS_MM = 5.0
"""A live pointer may go this much farther than a new one may come in, so that none flickers."""


@dataclass(frozen=True, slots=True)
class Motion:
    """How a finger moves, from its last two frames."""

    vx_mm_s: float = 0.0
    vy_mm_s: float = 0.0
    descent_mm_s: float = 0.0
    """Towards the surface, by the last frames in the air."""

    @property
    def speed_mm_s(self) -> float:
        """Along the surface."""
        return math.hypot(self.vx_mm_s, self.vy_mm_s)


def follow(before: Motion, last: Pointer | None, now: Pointer, elapsed_us: int) -> Motion:
    """Advance a motion by one frame, from a pointer's last frame to its present one."""
    if last is None:
        return before
    seconds = max(elapsed_us, 1) / 1e6
    share = 1.0 - math.exp(-seconds * 1e3 / SMOOTHING_MS)
    descent = (last.hover_mm - now.hover_mm) / seconds
    return Motion(
        before.vx_mm_s + share * ((now.x_mm - last.x_mm) / seconds - before.vx_mm_s),
        before.vy_mm_s + share * ((now.y_mm - last.y_mm) / seconds - before.vy_mm_s),
        descent if last.state is Touch.HOVER else 0.0,
    )


def describe(
    id: int,  # noqa: A002 - the wire's name
    slot: int,
    tip: Fingertip,
    signal: Signal,
    level: float,
    contact: Contact,
    states: TouchStates,
) -> Pointer:
    """Make a pointer of what was sensed; its velocity is not known yet."""
    pressure = touch_pressure(signal, states) if contact.touching else 0.0
    return Pointer(
        id=id,
        slot=slot,
        side=tip.side,
        finger=tip.finger,
        state=Touch.TOUCH if contact.touching else Touch.HOVER,
        x_mm=tip.pad_mm[0],
        y_mm=tip.pad_mm[1],
        hover_mm=0.0 if contact.touching else hover_height(signal, tip, states),
        pressure=pressure,
        force_g=force(pressure, states) if contact.touching else _no_force(states),
        vx_mm_s=0.0,
        vy_mm_s=0.0,
        confidence=tip.confidence,
        contacts=contact.count,
        diagnostics=Diagnostics(
            camera_mm=tip.camera_mm,
            tip_px=tip.tip_px,
            halo=signal.raw,
            halo_corrected=signal.corrected,
            level=level,
            top_mm=tip.top_mm,
            pitch_deg=tip.pitch_deg,
            yaw_deg=tip.yaw_deg,
        ),
    )


def within_reach(pointer: Pointer, live: bool, surface: Surface, settings: SensingSettings) -> bool:
    """Say whether a fingertip is near enough to the surface and its edges to be a pointer."""
    slack = RANGE_HYSTERESIS_MM if live else 0.0
    margin = settings.edge_margin_mm + slack
    return (
        pointer.hover_mm <= settings.hover_range_mm + slack
        and -margin <= pointer.x_mm <= surface.width_mm + margin
        and -margin <= pointer.y_mm <= surface.height_mm + margin
    )


def _no_force(states: TouchStates) -> float:
    """In the air the force is nothing where forces are known at all."""
    return FORCE_UNKNOWN_G if states.touch.force_g < 0.0 else 0.0
