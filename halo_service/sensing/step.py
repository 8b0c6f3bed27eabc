"""The story of one frame, on one screen.

`Frame -> Fingertips -> Halo signals -> Contacts -> TouchFrame`

The hand tracker stands outside: it is stateful and late, and hands in what it last saw.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from halo_service.profile import Profile, TouchStates
from halo_service.sensing.background import Drift, excess_depth, follow_drift
from halo_service.sensing.correction import correct, dent_at_pitch, dent_strength
from halo_service.sensing.debounce import debounce
from halo_service.sensing.dent import dent_under
from halo_service.sensing.detector import detect
from halo_service.sensing.extraction import extract
from halo_service.sensing.fingers import (
    REMEMBERED,
    Memory,
    Past,
    changes,
    claim,
    expect,
    is_better,
    meet,
    sighted,
    waiting,
)
from halo_service.sensing.fingertips import locate
from halo_service.sensing.pointers import describe, follow, within_reach
from halo_service.sensing.revealer import Revealed, reveal
from halo_service.sensing.ridge import height_behind
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.sightings import sightings
from halo_service.sensing.states import touch_level
from halo_service.sensing.territory import (
    Expected,
    Shares,
    is_finger,
    share,
    strip_end,
    territory,
)
from halo_service.values import Fingertip, Frame, Signal, TouchEvent, TouchFrame, Tracked

STILL = (0.0, 0.0)
"""Where a finger is expected, it is expected now."""
LEAST_TOP_MM, JOINT_PX = 5.0, 20.0
"""A finger's upper side stands higher than this 2 cm behind its end, where no press hides it; what
does not is surface."""
DEFAULT_SURFACE = ("table", 300.0, 200.0)
"""Name, width and height in mm of a surface that nobody has calibrated."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All that one frame leaves to the next."""

    profile: Profile | None
    """None before any calibration: frames then have no pointers."""
    settings: SensingSettings
    fingers: tuple[Memory, ...] = ()
    next_id: int = 1
    drift: Drift = Drift()  # noqa: RUF009 - frozen, so one default serves all


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What all fingers of a frame are sought in."""

    frame: Frame
    revealed: Revealed
    shares: Shares
    profile: Profile
    settings: SensingSettings


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """One finger in the present frame."""

    tip: Fingertip
    own: Revealed
    """The scene as far as it is this finger's."""
    followed: bool
    """Along its path, rather than where the tracker saw it anew."""


def start(profile: Profile | None, settings: SensingSettings) -> State:
    """Return the state before the first frame."""
    return State(profile, settings)


def step(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
    """Sense one frame. `tracked`: the newest that the hand tracker has, or None."""
    profile, settings = state.profile, state.settings
    if profile is None or profile.touch is None:
        return clear(state, frame.time_us)
    excess_mm = excess_depth(frame.depth, profile.background, state.drift.offset_mm)
    revealed = reveal(excess_mm, settings, profile.halo_threshold_mm)
    fingers: list[Memory] = []
    events: list[TouchEvent] = []
    known = meet(state.fingers, sightings(tracked, settings.fingers), state.next_id)
    places = [expect(finger, frame.time_us) for finger in known]
    scene = Scene(frame, revealed, share(places, frame.depth.shape), profile, settings)
    for number, (before, place) in enumerate(zip(known, places, strict=True)):
        finger = follow_finger(before, place, number, scene)
        events += changes(before, finger)
        if finger is not None:
            fingers.append(finger)
    next_id = max([state.next_id, *(finger.id + 1 for finger in fingers)])
    told = _frame(state, frame.time_us, fingers, events)
    drift = follow_drift(state.drift, excess_mm, frame.time_us)
    return told, replace(state, fingers=tuple(fingers), next_id=next_id, drift=drift)


def follow_finger(before: Memory, expected: Expected, number: int, scene: Scene) -> Memory | None:
    """Take one finger through all stages into the present frame; None when it is gone."""
    profile, settings, now_us = scene.profile, scene.settings, scene.frame.time_us
    states = profile.states(before.side)
    assert states is not None  # `step` senses with a whole profile alone
    found = find(before, expected, number, scene, states)
    if found is None:
        return waiting(before, now_us, settings)
    tip = found.tip
    signal = measure(found.own, tip, profile)
    level = touch_level(signal.corrected, states)
    detector = detect(before.detector, level, now_us, before.motion.speed_mm_s, settings)
    bounced = debounce(before.debounce, detector.touching, detector.ago_us, now_us)
    pointer = describe(before.id, before.slot, tip, signal, level, bounced.contact, states)
    motion = follow(before.motion, pointer, now_us)
    vx_mm_s, vy_mm_s = motion.velocity_mm_s
    if not within_reach(pointer, before.pointer is not None, profile.surface, settings):
        return None
    return replace(
        before,
        pointer=replace(pointer, vx_mm_s=vx_mm_s, vy_mm_s=vy_mm_s),
        path=(*(before.path if found.followed else ()), Past(now_us, tip.tip_px))[-REMEMBERED:],
        shown_us=now_us,
        detector=detector,
        debounce=bounced,
        motion=motion,
    )


def find(
    finger: Memory, expected: Expected, number: int, scene: Scene, states: TouchStates
) -> Found | None:
    """Return a fingertip in the present frame, None where none shows."""
    own = territory(scene.revealed, scene.shares, number, expected)
    tip = _tip(finger, expected, own, scene, states)
    claimed = claim(finger, scene.frame.time_us)
    if claimed is not None and (tip is None or finger.astray):
        there = territory(scene.revealed, scene.shares, number, claimed)
        seen = _tip(finger, claimed, there, scene, states)
        if seen is not None and is_better(finger, seen, tip):
            return Found(seen, there, followed=False)
    if tip is None:
        farther = replace(expected, tip_px=strip_end(own.hand, expected))
        tip = _tip(finger, farther, own, scene, states)
    return None if tip is None else Found(tip, own, followed=True)


def _tip(
    finger: Memory, place: Expected, own: Revealed, scene: Scene, states: TouchStates
) -> Fingertip | None:
    """Return the fingertip about a place, or None where no finger is."""
    sighting = sighted(finger, place)
    tip = locate(
        sighting,
        STILL,
        own,
        scene.frame.depth,
        scene.profile,
        states.finger_thickness_mm,
        states.tip_radius_mm,
    )
    behind_mm = height_behind(own.excess_mm, tip.tip_px, place.direction, JOINT_PX)
    lies = behind_mm < LEAST_TOP_MM  # false for nan: unmeasured
    # By its two sides, which stand out of the deepest dent; else by the flesh above the surface.
    shows = math.isfinite(tip.width_mm) or is_finger(own.hand, tip.tip_px, place.direction)
    return tip if shows and not lies else None


def measure(revealed: Revealed, tip: Fingertip, profile: Profile) -> Signal:
    """Read the halo around one fingertip."""
    raw = extract(revealed, tip)
    known = profile.correction
    dent_mm = dent_under(revealed, tip, profile) / dent_strength(known, *tip.pad_mm)
    pressed_mm = dent_mm / dent_at_pitch(known, tip.pitch_deg)
    return Signal(raw, correct(raw, tip, known), dent_mm, pressed_mm)


def adopt(state: State, profile: Profile) -> State:
    """Go on with another profile. Every finger begins anew in the air, so a touch owes its up."""
    fingers = tuple(replace(finger, detector=None) for finger in state.fingers)
    return replace(state, profile=profile, fingers=fingers, drift=Drift())


def clear(state: State, time_us: int) -> tuple[TouchFrame, State]:
    """Let all pointers go: what a frame that cannot be sensed says, so that nothing sticks."""
    events = [event for finger in state.fingers for event in changes(finger, None)]
    return _frame(state, time_us, (), events), replace(state, fingers=())


def _frame(
    state: State, time_us: int, fingers: Sequence[Memory], events: Sequence[TouchEvent]
) -> TouchFrame:
    surface = state.profile.surface if state.profile else None
    name, width_mm, height_mm = (
        (surface.name, surface.width_mm, surface.height_mm) if surface else DEFAULT_SURFACE
    )
    pointers = tuple(finger.pointer for finger in fingers if finger.pointer is not None)
    return TouchFrame(time_us, name, width_mm, height_mm, pointers, tuple(events))
