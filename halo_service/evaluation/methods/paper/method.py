"""HaloTouch to the letter (Xia et al. 2025, sections 4.3 and 6.2), on the same frames as ours.

In the paper's order a frame waits for its own hands. So frames are buffered until the tracker
has their hands, and a report is as many frames old as the tracker is late.

Its four states must be measured with its own signal: the evaluation does it, with `learn`. `halo
replay` reads those of the profile, which were measured on the refined fingertip; the raw landmark
is over a different part of the halo, so levels, heights and pressures are off there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from halo_service.evaluation.methods.paper.calibrate import learn
from halo_service.evaluation.methods.paper.detector import Detector, detect
from halo_service.evaluation.methods.paper.signal import Reading, corrected, read
from halo_service.evaluation.methods.pointers import (
    LEAST_PRESSURE,
    Identity,
    Published,
    Spot,
    identify,
    pointer_of,
    publish,
    within_reach,
)
from halo_service.geometry.surface import Surface
from halo_service.profile import Correction, Profile, TouchStates
from halo_service.runtime.method import Method
from halo_service.sensing import SensingSettings
from halo_service.sensing.states import interpolate
from halo_service.values import Finger, Frame, Hand, Pointer, TouchFrame, Tracked

LINE_REACH_MM = 15.0
"""Where no halo is left on the finger's line (paper 4.3.6)."""
MOST_WAITING = 8
"""Frames buffered for the tracker: the slowest one's lag."""
LOST_US = 250_000
"""A finger that the tracker has not found for so long is gone, as in ours."""


@dataclass(frozen=True, slots=True)
class Followed:
    """One finger between two frames."""

    pointer: Pointer
    detector: Detector
    seen_us: int
    """Time of the last frame with it."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Everything that one frame passes to the next."""

    profile: Profile | None
    settings: SensingSettings
    correct: Callable[[Reading, Correction | None], float] = corrected
    """Stage 4.3.4, by the profile's grid; the latency runs use the regressor itself."""
    waiting: tuple[Frame, ...] = ()
    """Frames that wait for their hands, oldest first."""
    sensed_us: int = -1
    """Time of the newest frame that was sensed."""
    last: Published = field(default_factory=Published)
    fingers: Mapping[int, Followed] = field(default_factory=dict)
    """By the pointers' ids."""


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    return State(profile, settings)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense the frame of the tracker's newest hands, once; without new hands nothing changes."""
    profile = state.profile
    if profile is None or profile.touch is None:
        return clear(state, frame.time_us)
    waiting = (*state.waiting, frame)[-MOST_WAITING:]
    newest_us = -1 if tracked is None else tracked.time_us
    due = next((each for each in waiting if each.time_us == newest_us > state.sensed_us), None)
    fingers: dict[int, Followed | None] = {**state.fingers}
    if due is not None and tracked is not None:
        fingers.update(sense(state, due, tracked.hands, profile, profile.touch))
    left = {
        number: finger
        for number, finger in fingers.items()
        if finger is not None and frame.time_us - finger.seen_us <= LOST_US
    }
    pointers = [finger.pointer for finger in left.values()]
    ago_ms = 0.0 if due is None else (frame.time_us - due.time_us) / 1e3
    touch_frame, last = publish(state.last, pointers, frame.time_us, profile, ago_ms)
    sensed_us = state.sensed_us if due is None else due.time_us
    return touch_frame, replace(
        state, waiting=waiting, sensed_us=sensed_us, last=last, fingers=left
    )


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Release all pointers."""
    touch_frame, last = publish(state.last, (), time_us, state.profile)
    return touch_frame, replace(state, waiting=(), last=last, fingers={})


def sense(
    state: State, frame: Frame, hands: tuple[Hand, ...], profile: Profile, usual: TouchStates
) -> dict[int, Followed | None]:
    """Run all stages for every hand's index finger; None for one that is too far away.

    `usual`: the four states for a hand without its own.
    """
    readings = [read(frame.depth, hand, profile) for hand in hands]
    signals = [state.correct(reading, profile.correction) for reading in readings]
    spots = [
        _spot(*each, profile.states(each[0].side) or usual)
        for each in zip(hands, readings, signals, strict=True)
    ]
    sensed: dict[int, Followed | None] = {}
    for identity, spot, reading in zip(identify(state.last, spots), spots, readings, strict=True):
        past = state.fingers.get(identity.id)
        seconds = (frame.time_us - past.seen_us) / 1e6 if past else 1.0
        speed_mm_s = _moved_mm(identity, spot) / seconds
        detector = detect(past.detector if past else None, spot.level, speed_mm_s, frame.time_us)
        states = profile.states(spot.side) or usual
        pointer = _pointer(identity, spot, detector.touching, seconds, states, profile.surface)
        near = _near(identity, spot, reading, profile.surface, state.settings)
        sensed[identity.id] = Followed(pointer, detector, frame.time_us) if near else None
    return sensed


def _spot(hand: Hand, reading: Reading, signal: float, states: TouchStates) -> Spot:
    level = interpolate(signal, states.subtle.signal, states.touch.signal, 0.0, 1.0)
    return Spot(
        place_mm=reading.place_mm,
        tip_px=reading.tip_px,
        height_mm=_height(signal, reading.line_px, states),
        side=hand.side,
        finger=Finger.INDEX,
        confidence=hand.confidence,
        pitch_deg=reading.pitch_deg,
        yaw_deg=reading.yaw_deg,
        halo=reading.raw,
        halo_corrected=signal,
        level=max(level, 0.0),  # farther than the subtle state is simply in the air
    )


def _height(signal: float, line_px: int, states: TouchStates) -> float:
    """Return the height, mm: linear in the signal, above it in the halo pixels left on the line."""
    hover, subtle = states.hover, states.subtle
    if signal > hover.signal:
        height = interpolate(signal, hover.signal, subtle.signal, hover.height_mm, subtle.height_mm)
        return max(height, 0.0)
    if states.line_px_at_hover <= 0.0:
        # Even the hover state showed no pixel, so none can be missed: the middle of the range.
        return (hover.height_mm + LINE_REACH_MM) / 2.0
    left = min(line_px / states.line_px_at_hover, 1.0)
    return LINE_REACH_MM - left * (LINE_REACH_MM - hover.height_mm)


def _pointer(
    identity: Identity,
    spot: Spot,
    touching: bool,
    seconds: float,
    states: TouchStates,
    surface: Surface,
) -> Pointer:
    touch, press = states.touch, states.pressure
    pressure = interpolate(spot.halo_corrected, touch.signal, press.signal, 0.0, 1.0)
    force_g = -1.0
    if touch.force_g >= 0.0 and press.force_g >= 0.0:
        share = max(pressure, 0.0)
        force_g = touch.force_g + share * (press.force_g - touch.force_g) if touching else 0.0
    least = max(pressure, LEAST_PRESSURE)
    return pointer_of(identity, spot, touching, surface, seconds, least, force_g)


def _near(
    identity: Identity, spot: Spot, reading: Reading, surface: Surface, settings: SensingSettings
) -> bool:
    """Whether a finger is near the surface; only its own depth says how high it is."""
    higher = replace(spot, height_mm=0.0 if math.isnan(reading.top_mm) else reading.top_mm)
    return within_reach(identity, higher, surface, settings.hover_range_mm, settings.edge_margin_mm)


def _moved_mm(identity: Identity, spot: Spot) -> float:
    if identity.before is None:
        return 0.0
    return math.dist((identity.before.x_mm, identity.before.y_mm), spot.place_mm)


PAPER = Method("paper", start, step, clear, learn, whole_image=True)
