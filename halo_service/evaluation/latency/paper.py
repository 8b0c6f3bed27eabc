"""The paper's stages after the hand tracker, one frame at a time (section 4.3), for their cost.

Written for this bench's clock: how well the method touches is judged elsewhere. What would add
a frame or more (typing's debounce, section 4.3.6) is left out, in its favour.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Background, Profile, TouchStates
from halo_service.profile.model import PAPER_THRESHOLD_MM
from halo_service.values import (
    Depth,
    Diagnostics,
    Finger,
    Hand,
    Pointer,
    Side,
    Touch,
    TouchEvent,
    TouchFrame,
)

TIP, DISTAL = 8, 7
"""MediaPipe's landmarks of the index finger."""
PATCH_PX = (30, 20)
"""Width and height of the patch around the tip (4.3.3)."""
DEPARTURE, RISE = 0.2, 0.05
"""Of the level at a touch: from its baseline, and since the frame before (chosen: the paper calls
both thresholds, and names neither)."""
UP_LEVEL = 0.1
"""Chosen likewise."""
BASELINE_SHARE = 0.08
"""How much of a frame's level the baseline takes up (chosen: 0.4 s)."""
UNKNOWN_G = -1.0


@dataclass(frozen=True, slots=True)
class Tip:
    """A fingertip as two landmarks and their depths show it."""

    side: Side
    tip_px: tuple[float, float]
    camera_mm: tuple[float, float, float]
    x_mm: float
    y_mm: float
    top_mm: float
    """Height of what the camera sees there above the surface."""
    pitch_deg: float
    yaw_deg: float
    confidence: float


@dataclass(frozen=True, slots=True)
class Index:
    """What is remembered of one hand's index finger."""

    id: int
    level: float
    baseline: float
    touching: bool = False
    contacts: int = 0


def fingertip(hand: Hand, depth: Depth, profile: Profile) -> Tip | None:
    """Place the tip by its landmark and the depth there; None where there is none."""
    marks = hand.landmarks_px[[TIP, DISTAL]]
    columns, rows = np.rint(marks).astype(int).T
    height, width = depth.shape
    if (
        (columns < 0).any()
        or (rows < 0).any()
        or (columns >= width).any()
        or (rows >= height).any()
    ):
        return None
    seen_mm = depth[rows, columns]
    if (seen_mm == 0).any():
        return None
    in_camera = profile.camera.depth.rays(marks) * seen_mm[:, None]
    tip, joint = profile.surface.from_camera(in_camera)
    across, forward, down = (tip - joint).tolist()
    x, y, z = in_camera[0].tolist()
    return Tip(
        hand.side,
        (float(marks[0, 0]), float(marks[0, 1])),
        (x, y, z),
        float(tip[0]),
        float(tip[1]),
        float(-tip[2]),
        math.degrees(math.atan2(down, math.hypot(across, forward))),
        math.degrees(math.atan2(across, -forward)),
        hand.confidence,
    )


def excess(depth: Depth, background: Background) -> NDArray[np.float32]:
    """(H, W) mm above the threshold where the surface reads farther, else 0 (4.3.1)."""
    farther = depth.astype(np.float32) - background.mean_mm
    halo = (farther > PAPER_THRESHOLD_MM) & (depth > 0) & background.valid
    return np.where(halo, farther, np.float32(0.0))


def signal(halo_mm: NDArray[np.float32], tip: Tip) -> float:
    """Sum the patch around a tip, mm px."""
    left, top = (round(at) - size // 2 for at, size in zip(tip.tip_px, PATCH_PX, strict=True))
    rows = slice(max(top, 0), max(top + PATCH_PX[1], 0))
    return float(halo_mm[rows, max(left, 0) : max(left + PATCH_PX[0], 0)].sum())


class Touches:
    """The touch detector of 4.3.6, one index finger a hand."""

    def __init__(self, profile: Profile, states: TouchStates) -> None:
        self._surface = profile.surface
        self._states = states
        self._fingers: dict[Side, Index] = {}
        self._next_id = 1

    def frame(self, time_us: int, seen: list[tuple[Tip, float]]) -> TouchFrame:
        """Make the frame of tips and their corrected signals."""
        pointers: list[Pointer] = []
        events: list[TouchEvent] = []
        before, self._fingers = self._fingers, {}
        for tip, value in seen:
            last = before.pop(tip.side, None)
            now = self._advance(last, value)
            self._fingers[tip.side] = now
            pointers.append(self._pointer(tip, now, value))
            if last is not None and last.touching != now.touching:
                events.append(_event(pointers[-1]))
        surface = self._surface
        return TouchFrame(
            time_us,
            surface.name,
            surface.width_mm,
            surface.height_mm,
            tuple(pointers),
            tuple(events),
        )

    def _advance(self, last: Index | None, value: float) -> Index:
        subtle, touch = self._states.subtle.signal, self._states.touch.signal
        level = (value - subtle) / (touch - subtle)
        if last is None:
            self._next_id += 1
            return Index(self._next_id - 1, level, level)
        if last.touching:
            return replace(last, level=level, touching=level >= UP_LEVEL)
        departed = abs(level - last.baseline) > DEPARTURE
        touching = departed and level - last.level >= RISE
        followed = last.baseline + BASELINE_SHARE * (level - last.baseline)
        return replace(
            last,
            level=level,
            baseline=last.baseline if touching else followed,
            touching=touching,
            contacts=last.contacts + touching,
        )

    def _pointer(self, tip: Tip, now: Index, value: float) -> Pointer:
        states = self._states
        span = states.pressure.signal - states.touch.signal
        height = 1.0 + 9.0 * (states.subtle.signal - value) / max(
            states.subtle.signal - states.hover.signal, 1.0
        )
        return Pointer(
            id=now.id,
            slot=(now.id - 1) % 10,
            side=tip.side,
            finger=Finger.INDEX,
            state=Touch.TOUCH if now.touching else Touch.HOVER,
            x_mm=tip.x_mm,
            y_mm=tip.y_mm,
            hover_mm=0.0 if now.touching else max(height, 0.0),
            pressure=max((value - states.touch.signal) / span, 0.02) if now.touching else 0.0,
            force_g=UNKNOWN_G,
            vx_mm_s=0.0,
            vy_mm_s=0.0,
            confidence=tip.confidence,
            contacts=now.contacts,
            diagnostics=Diagnostics(
                camera_mm=tip.camera_mm,
                tip_px=tip.tip_px,
                halo=value,
                halo_corrected=value,
                level=now.level,
                top_mm=tip.top_mm,
                pitch_deg=tip.pitch_deg,
                yaw_deg=tip.yaw_deg,
            ),
        )


def _event(pointer: Pointer) -> TouchEvent:
    down = pointer.state is Touch.TOUCH
    return TouchEvent(
        kind="down" if down else "up",
        id=pointer.id,
        slot=pointer.slot,
        x_mm=pointer.x_mm,
        y_mm=pointer.y_mm,
        strike_mm_s=0.0,
        ago_ms=0.0,
        contacts=pointer.contacts,
    )
