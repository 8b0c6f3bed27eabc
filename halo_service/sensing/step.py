"""The whole pipeline for one frame, on one screen.

`Frame -> hands -> tracks -> fingertip measurements -> contacts -> TouchFrame -> bytes`

The hand tracker runs outside: it is stateful and late, and passes in the hands that it found last.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from halo_service.profile import Profile, TouchStates
from halo_service.sensing.association import associate, load_solver
from halo_service.sensing.background import Drift, follow_drift
from halo_service.sensing.contact import Evidence, evidence
from halo_service.sensing.correction import at_pitch, correct, leveled, leveled_top
from halo_service.sensing.debounce import debounce
from halo_service.sensing.detections import detections
from halo_service.sensing.detector import detect
from halo_service.sensing.nail import pad_under_nail
from halo_service.sensing.pointers import came_over_edge, describe, edge, follow, within_reach
from halo_service.sensing.readings import readings
from halo_service.sensing.registration import REMEMBERED, HeightMap, height_map
from halo_service.sensing.scale import Scale, on_surface
from halo_service.sensing.scene import Found, Scene, find, look
from halo_service.sensing.segmentation import Segmentation
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.tracks import (
    Track,
    carry,
    changes,
    coast,
    is_abandoned,
    measured,
    tracker_confidence,
)
from halo_service.values import Fingertip, Frame, Signal, TouchEvent, TouchFrame, Tracked

DEFAULT_SURFACE = ("table", 300.0, 200.0)
"""Name, width and height in mm of a surface without calibration."""

NEIGHBOUR_MM = 40.0
"""The halos of two fingers that are farther apart do not meet (chosen: twice a halo's radius)."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All that one frame passes to the next."""

    profile: Profile | None
    """None before any calibration: frames then have no pointers."""
    settings: SensingSettings
    fingers: tuple[Track, ...] = ()
    next_id: int = 1
    maps: tuple[HeightMap, ...] = ()
    """Of the last frames, oldest first."""
    drift: Drift = Drift()  # noqa: RUF009 - frozen, so one default serves all


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    if settings.fingers == "all":
        load_solver()  # now, and not in the first frame with a hand
    return State(profile, settings)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense one frame. `tracked`: the newest hands that the tracker found, or None."""
    profile, settings = state.profile, state.settings
    if profile is None or profile.touch is None:
        return clear(state, frame.time_us)
    scale = Scale(frame.depth, profile)
    detected = detections(tracked, scale, settings.fingers)
    drift_mm, size = state.drift.offset_mm, scale.on_surface
    newest = height_map(frame.time_us, frame.depth, profile.background, drift_mm, size)
    maps = (*state.maps, newest)[-REMEMBERED:]
    carried = tuple(carry(finger, maps, size) for finger in state.fingers)
    tracks = associate(carried, detected, state.next_id, maps)
    scene = look(frame, tracks, scale, settings, drift_mm)
    measurements = [measure_finger(before, number, scene) for number, before in enumerate(tracks)]
    fingers: list[Track] = []
    events: list[TouchEvent] = []
    for before, now in zip(tracks, measurements, strict=True):
        finger = follow_finger(before, now, _neighbour_rise(now, measurements), scene)
        events += changes(before, finger)
        if finger is not None:
            fingers.append(finger)
    next_id = max([state.next_id, *(finger.id + 1 for finger in fingers)])
    touch_frame = _frame(state, frame.time_us, fingers, events)
    drift = follow_drift(state.drift, frame.depth, profile.background, frame.time_us)
    return touch_frame, State(profile, settings, tuple(fingers), next_id, maps, drift)


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """What the present frame shows of one finger."""

    found: Found
    signal: Signal
    evidence: Evidence
    states: TouchStates
    rise: float
    """How far its level is above its rest."""


def measure_finger(before: Track, number: int, scene: Scene) -> Measurement | None:
    """Measure one finger in the present frame; None if it does not show."""
    states = scene.profile.states(before.side)
    assert states is not None  # `step` senses only with a complete profile
    if is_abandoned(before, scene.frame.time_us):
        return None
    found = find(before, number, scene, states)
    if found is None:
        return None
    signal = measure(found.own, found.tip, scene.profile)
    shown = evidence(signal, found.tip, states)
    rise = shown.level - before.detector.rest if before.detector else 0.0
    return Measurement(found, signal, shown, states, rise)


def follow_finger(
    before: Track, now: Measurement | None, neighbour_rise: float, scene: Scene
) -> Track | None:
    """Return a finger after the present frame; None if it is gone.

    `neighbour_rise`: see `detect`.
    """
    profile, settings, now_us = scene.profile, scene.settings, scene.frame.time_us
    if is_abandoned(before, now_us):
        return None
    if now is None:
        return coast(before, now_us, settings)
    found, signal, states = now.found, now.signal, now.states
    tip = found.tip
    place_mm = pad_under_nail(tip.pad_mm, tip.pitch_deg, tip.yaw_deg, states.nail_mm)
    came_in = came_over_edge(before.motion, place_mm, now_us, profile.surface)
    speed_mm_s = before.motion.speed_mm_s
    detector = detect(
        before.detector, now.evidence, now_us, speed_mm_s, settings, came_in, neighbour_rise
    )
    bounced = debounce(before.debounce, detector.touching, detector.ago_us, now_us)
    pointer = describe(before.id, before.slot, tip, signal, detector, bounced.contact, states)
    motion = follow(before.motion, pointer, now_us)
    vx_mm_s, vy_mm_s = motion.velocity_mm_s
    if not within_reach(pointer, before.pointer is not None, profile.surface, settings):
        return None
    confidence = (
        pointer.confidence * tracker_confidence(before, now_us) * edge(pointer, profile.surface)
    )
    return replace(
        measured(before, now_us, tip, found.followed, on_surface(profile), found.hidden),
        pointer=replace(pointer, vx_mm_s=vx_mm_s, vy_mm_s=vy_mm_s, confidence=confidence),
        detector=detector,
        debounce=bounced,
        motion=motion,
    )


def _neighbour_rise(finger: Measurement | None, others: Sequence[Measurement | None]) -> float:
    """Return the highest rise of the fingers whose halos reach one, at least 0."""
    if finger is None:
        return 0.0
    pad_mm = finger.found.tip.pad_mm
    rises = (
        each.rise
        for each in others
        if each and each is not finger and math.dist(each.found.tip.pad_mm, pad_mm) < NEIGHBOUR_MM
    )
    return max(max(rises, default=0.0), 0.0)


def measure(segmentation: Segmentation, tip: Fingertip, profile: Profile) -> Signal:
    """Read the halo around one fingertip."""
    read, correction = readings(segmentation, tip, profile), profile.correction
    values, deviations = leveled(read, correction, *tip.pad_mm)
    turned = at_pitch(correction, tip.pitch_deg)
    top = leveled_top(tip, correction)
    return Signal(read[0], correct(read[0], tip, correction), values, deviations, turned, *top)


def adopt(state: State, profile: Profile) -> State:
    """Continue with another profile. Fingers start again in the air, so a touch gets its up."""
    fingers = tuple(replace(finger, detector=None) for finger in state.fingers)
    return replace(state, profile=profile, fingers=fingers, maps=(), drift=Drift())


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Release all pointers, for a frame that cannot be sensed."""
    events = [event for finger in state.fingers for event in changes(finger, None)]
    return _frame(state, time_us, (), events), replace(state, fingers=(), maps=())


def _frame(
    state: State, time_us: int, fingers: Sequence[Track], events: Sequence[TouchEvent]
) -> TouchFrame:
    surface = state.profile.surface if state.profile else None
    name, width_mm, height_mm = (
        (surface.name, surface.width_mm, surface.height_mm) if surface else DEFAULT_SURFACE
    )
    pointers = tuple(finger.pointer for finger in fingers if finger.pointer is not None)
    return TouchFrame(time_us, name, width_mm, height_mm, pointers, tuple(events))
