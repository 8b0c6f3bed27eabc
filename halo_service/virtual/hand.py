"""Hand postures: from fingertip targets to the angles of every joint.

Rule: pure geometry. The pad's lowest point lies exactly at the target: that point is the truth
for every later measurement.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from halo_service.values import Finger, Side
from halo_service.virtual.anatomy import PLANS, bone_of, finger_direction
from halo_service.virtual.mesh import Floats
from halo_service.virtual.skeleton import (
    Angles,
    FingerPose,
    HandPose,
    User,
    about_x,
    about_z,
    bones_of,
    indentation_mm,
    joints_of,
)

CURLED: dict[Finger, Angles] = {
    Finger.THUMB: (4.0, 14.0, 22.0),
    Finger.INDEX: (38.0, 105.0, 50.0),
    Finger.MIDDLE: (38.0, 105.0, 50.0),
    Finger.RING: (40.0, 105.0, 50.0),
    Finger.LITTLE: (42.0, 102.0, 50.0),
}
"""Fingers near the palm, as the paper's participants held them (5.1); angles chosen."""
RELAXED: dict[Finger, Angles] = {
    Finger.THUMB: (8.0, 10.0, 15.0),
    Finger.INDEX: (8.0, 24.0, 14.0),
    Finger.MIDDLE: (6.0, 30.0, 16.0),
    Finger.RING: (8.0, 32.0, 16.0),
    Finger.LITTLE: (8.0, 30.0, 14.0),
}
"""Fingers loose in the air, chosen."""

_PITCHES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
_HAND = (4.0, 8.0, 10.0, 14.0, 20.0, 26.0, 34.0)
_MIDDLE_JOINT = (-8.0, -7.0, -2.0, 5.0, 13.0, 20.0, 26.0)
_LAST_JOINT = (-22.0, -18.0, -10.0, -2.0, 3.0, 8.0, 12.0)
"""How people reach a pitch: the whole hand tilts, and the finger arches (chosen, so that curled
fingers stay clear of the table)."""

FIST_TILT_DEG = 12.0
"""How far a closed hand on the table leans forward, chosen."""
CLEAR_MM, LIFT_DEG, MOST_LIFTS = 4.0, 6.0, 12
"""People hold the fingers that do not point clear of the table: how far, and in what steps."""
THUMB_FOLD_DEG = 26.0
"""How far a pointing hand's thumb lies in towards the index finger, chosen."""


THUMB_OUT_DEG = -24.0
"""The thumb's angle when it is spread, chosen."""


def pointing(
    user: User,
    side: Side,
    aim: FingerPose,
    *,
    finger: Finger = Finger.INDEX,
    curl: float = 1.0,
) -> HandPose:
    """A hand whose `finger` is as `aim` says; `curl`: the others, 0 loose to 1 near the palm."""
    tilt = float(np.interp(aim.pitch_deg, _PITCHES, _HAND))
    middle = float(np.interp(aim.pitch_deg, _PITCHES, _MIDDLE_JOINT))
    last = float(np.interp(aim.pitch_deg, _PITCHES, _LAST_JOINT))
    flexion = [_between(RELAXED[f], CURLED[f], curl) for f in Finger]
    flexion[finger] = (aim.pitch_deg - tilt - middle - last, middle, last)
    spread, force = [0.0] * 5, [0.0] * 5
    if finger is not Finger.THUMB:
        spread[Finger.THUMB] = _thumb_deg(user, curl)
    force[finger] = aim.force_g
    pose = HandPose(side, np.eye(4), tuple(flexion), tuple(spread), 4.0 - 0.55 * tilt, tuple(force))
    return _clear(user, place(user, pose, aim, finger), but=finger)


def _thumb_deg(user: User, curl: float) -> float:
    folded = THUMB_FOLD_DEG * curl
    return folded + (THUMB_OUT_DEG - folded) * user.thumb_out


def open_hand(
    user: User,
    side: Side,
    aim: FingerPose,
    heights_mm: Mapping[Finger, float],
    forces_g: Mapping[Finger, float],
    spread_deg: float = 0.0,
) -> HandPose:
    """All fingers out: the hand hangs as if its index finger pointed at `aim`, and each finger
    then bends at the knuckle until its pad is at its own height."""
    force = tuple(forces_g.get(f, 0.0) for f in Finger)
    fan = tuple(spread_deg * (int(f) - 2) / 2.0 if f is not Finger.THUMB else 0.0 for f in Finger)
    relaxed = tuple(RELAXED[f] for f in Finger)
    pose = place(user, HandPose(side, np.eye(4), relaxed, fan, 4.0, force), aim, Finger.INDEX)
    flexion = [(_knuckle(user, pose, f, heights_mm.get(f, 20.0)), *RELAXED[f][1:]) for f in Finger]
    return dataclasses.replace(pose, flexion=tuple(flexion))


def resting(user: User, side: Side, x_mm: float, y_mm: float, yaw_deg: float) -> HandPose:
    """A flat hand lying on the table, its middle finger's knuckle at a place."""
    flat: dict[Finger, Angles] = dict.fromkeys(Finger, (2.0, 6.0, 4.0))
    flat[Finger.THUMB] = (-8.0, 2.0, 2.0)
    yaw = about_z(np.radians(yaw_deg))
    knuckle = np.array(PLANS[Finger.MIDDLE].root) * user.size
    surface_from_hand = np.eye(4)
    surface_from_hand[:3, :3] = yaw
    surface_from_hand[:3, 3] = np.array([x_mm, y_mm, 0.0]) - yaw @ knuckle
    pose = HandPose(side, surface_from_hand, tuple(flat.values()), (0.0,) * 5, 12.0)
    surface_from_hand[2, 3] += _flesh_mm(user, pose).min()
    return pose


def fist(user: User, side: Side, x_mm: float, y_mm: float, yaw_deg: float) -> HandPose:
    """A closed hand with its knuckles on the table, all fingers curled in, near a place."""
    curled = tuple(CURLED[f] for f in Finger)
    folded = (THUMB_FOLD_DEG, 0.0, 0.0, 0.0, 0.0)
    surface_from_hand = np.eye(4)
    surface_from_hand[:3, :3] = about_z(np.radians(yaw_deg)) @ about_x(-np.radians(FIST_TILT_DEG))
    knuckle = np.array(PLANS[Finger.MIDDLE].root) * user.size
    surface_from_hand[:3, 3] = [x_mm, y_mm, 0.0] - surface_from_hand[:3, :3] @ knuckle
    pose = HandPose(side, surface_from_hand, curled, folded)
    surface_from_hand[2, 3] += _flesh_mm(user, pose)[:, 1:].min()
    return pose


def place(user: User, pose: HandPose, aim: FingerPose, finger: Finger) -> HandPose:
    """Turn and move a hand as a whole until `finger` is where `aim` wants it."""
    bones = bones_of(pose)
    tip = joints_of(bones)[finger, 3] * user.size
    along = bones[bone_of(finger, 2), :3, :3] @ finger_direction(PLANS[finger].yaw_deg)
    if pose.side is Side.LEFT:
        tip[0], along[0] = -tip[0], -along[0]
    # Tilt the hand until the last segment has its pitch, then turn it to its yaw.
    sine = np.sin(np.radians(aim.pitch_deg)) / np.hypot(along[1], along[2])
    lean = np.arcsin(np.clip(sine, -1.0, 1.0)) - np.arctan2(along[2], -along[1])
    ahead = about_x(-lean) @ along
    turn = np.radians(aim.yaw_deg) - np.arctan2(ahead[0], -ahead[1])
    rotation = about_z(turn) @ about_x(-lean)
    low = -aim.height_mm + indentation_mm(user, aim.force_g) - _radius(user, finger)
    surface_from_hand = np.eye(4)
    surface_from_hand[:3, :3] = rotation
    surface_from_hand[:3, 3] = np.array([aim.x_mm, aim.y_mm, low]) - rotation @ tip
    return dataclasses.replace(pose, surface_from_hand=surface_from_hand)


def _clear(user: User, pose: HandPose, but: Finger) -> HandPose:
    """Lift the fingers that would go through the table, all but one, at their first joint."""
    for _ in range(MOST_LIFTS):
        low = _flesh_mm(user, pose)[:, 1:].min(axis=1) < CLEAR_MM
        low[but] = False
        if not low.any():
            break
        flexion = [
            (a - LIFT_DEG, b, c) if low[f] else (a, b, c)
            for f, (a, b, c) in enumerate(pose.flexion)
        ]
        pose = dataclasses.replace(pose, flexion=tuple(flexion))
    return pose


def _flesh_mm(user: User, pose: HandPose) -> Floats:
    """(5, 4) heights above the table of the flesh under each finger's joints and tip."""
    places = joints_of(bones_of(pose)) * user.size
    if pose.side is Side.LEFT:
        places[..., 0] = -places[..., 0]
    depth = places @ pose.surface_from_hand[2, :3] + pose.surface_from_hand[2, 3]
    radii = np.array([PLANS[finger].radii for finger in Finger]) * user.girth * user.size
    return np.asarray(-(depth + radii), dtype=np.float64)


def _knuckle(user: User, pose: HandPose, finger: Finger, height_mm: float) -> float:
    """The first joint's angle, degrees, at which a finger's pad is at a height."""
    plan = PLANS[finger]
    straight = list(pose.flexion)
    straight[finger] = (0.0, *pose.flexion[finger][1:])
    rest = dataclasses.replace(pose, flexion=tuple(straight), spread=(0.0,) * 5)
    root = np.array(plan.root)
    yaw = np.radians(plan.yaw_deg)
    chain = about_z(-yaw) @ (joints_of(bones_of(rest))[finger, 3] - root) * user.size
    down = pose.surface_from_hand[2, :3].copy()
    if pose.side is Side.LEFT:
        down[0] = -down[0]
    # Depth of the pad = base + a cos(angle) + b sin(angle): solved on the way down.
    base = pose.surface_from_hand[2, 3] + down @ root * user.size + _radius(user, finger)
    down = down @ about_z(np.radians(pose.spread[finger]) + yaw)
    base += down[0] * chain[0]
    a = down[1] * chain[1] + down[2] * chain[2]
    b = down[1] * chain[2] - down[2] * chain[1]
    want = -height_mm + indentation_mm(user, pose.force_g[finger]) - base
    angle = np.arctan2(b, a) - np.arccos(np.clip(want / np.hypot(a, b), -1.0, 1.0))
    return float(np.degrees(angle))


def _radius(user: User, finger: Finger) -> float:
    return PLANS[finger].radii[3] * user.girth * user.size


def _between(a: Angles, b: Angles, share: float) -> Angles:
    x, y, z = (p + (q - p) * share for p, q in zip(a, b, strict=True))
    return x, y, z
