"""From posed hands to the halo they cast: which of their points hang low over the table.

Rule: places and heights only; `halo` has how deep a dent is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Finger
from halo_service.virtual import halo
from halo_service.virtual.halo import Dent, Glow, HaloCurve, dent_field, glow_field
from halo_service.virtual.mesh import Floats
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.skeleton import PosedHand

Fade = tuple[float, float, float]
Image = NDArray[np.float32]

PALM_RADIUS_MM = 12.0
"""Flesh under the palm's bones, of a middling hand."""
DENT_REACH = 2.2
"""Beyond this many radii a dent is below a thousandth of a millimetre."""
GLOW_HEIGHT_MM = (30.0, 90.0)
"""Height of a hand up to which its glow is whole, and at which it has ended; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class HaloPart:
    """Something that lowers what the table reads, around some places."""

    places_mm: Floats
    """(N, 2) on the surface."""
    reach_mm: float
    """How far from the places it can be seen."""
    field: Callable[[Image, Image], Image]
    """x and y on the surface, both (H, W), mm -> depth, mm."""


def halo_parts(room: Room, hands: Sequence[PosedHand], fade: Fade) -> list[HaloPart]:
    """The dents of all hands, and their glows; empty where no hand is low."""
    dents = [dent for hand in hands for dent in dents_of(room, hand, fade)]
    glows = [glow for hand in hands for glow in glows_of(room, hand, fade)]
    parts = []
    if dents:
        reach = DENT_REACH * max(dent.radius_mm * max(1.0, dent.stretch) for dent in dents)
        parts.append(HaloPart(_places(dents), reach, lambda x, y: dent_field(dents, x, y)))
    if glows:
        reach = halo.GLOW_FLESH_MM + halo.GLOW_REACH * max(glow.reach_mm for glow in glows)
        parts.append(HaloPart(_places(glows), reach, lambda x, y: glow_field(glows, x, y)))
    return parts


def dents_of(room: Room, hand: PosedHand, fade: Fade) -> list[Dent]:
    """Every fingertip and underside within the halo's reach."""
    dents = [_tip(room, hand, finger, fade) for finger in Finger]
    for finger in Finger:
        bones, radii = hand.joints[finger], hand.radii[finger]
        for segment in range(3):
            middle = (bones[segment] + bones[segment + 1]) / 2.0
            dents.append(_side(room, middle, (radii[segment] + radii[segment + 1]) / 2.0, fade))
    radius = _palm_radius_mm(room)
    for knuckle in hand.palm[1:]:
        for share in (0.1, 0.5, 0.95):
            place = hand.palm[0] + share * (knuckle - hand.palm[0])
            dents.append(_side(room, place, radius, fade))
    return [dent for dent in dents if dent is not None]


def glows_of(room: Room, hand: PosedHand, fade: Fade) -> list[Glow]:
    """The shallow glow around a low hand: one around each of its knuckles and fingertips."""
    curve = room.curve
    if curve.glow_mm == 0.0:
        return []
    palm = [(place, _palm_radius_mm(room)) for place in hand.palm]
    tips = [(hand.joints[f, 3], float(hand.radii[f, 3])) for f in Finger]
    glows = []
    for place, radius in (*palm, *tips):
        share = np.interp(-place[2] - radius, GLOW_HEIGHT_MM, (1.0, 0.0))
        deep = curve.glow_mm * fade[0] * float(share)
        if deep > 0.0:
            glows.append(Glow(float(place[0]), float(place[1]), deep, curve.glow_reach_mm))
    return glows


def _tip(room: Room, hand: PosedHand, finger: Finger, fade: Fade) -> Dent | None:
    """What a fingertip does; one that is curled in, its nail down, counts as any underside."""
    curve, pad = room.curve, hand.pad(finger)
    pitch, yaw = hand.pitch_yaw(finger)
    if not hand.pointing(finger):
        return _side(room, hand.joints[finger, 3], hand.radii[finger, 3], fade)
    height, force = max(0.0, -pad[2]), hand.force_g[finger]
    if height >= curve.onset_mm:
        return None
    deep = halo.depth(curve, height, force, fade) * halo.posture(pitch) * _by_place(curve, pad)
    radius = halo.radius_mm(room.camera_height_mm, curve, height, force)
    along = float(np.sin(np.radians(yaw))), -float(np.cos(np.radians(yaw)))
    x, y = (float(pad[k]) - curve.shift_mm * along[k] for k in (0, 1))
    return Dent(x, y, deep, radius, along, curve.stretch, curve.lopsided)


def _side(room: Room, centre: Floats, radius_mm: float, fade: Fade) -> Dent | None:
    height = max(0.0, -float(centre[2]) - radius_mm)
    if height >= room.curve.onset_mm:
        return None
    deep = halo.SIDE_WEIGHT * halo.depth(room.curve, height, 0.0, fade)
    if room.curve.corner_fall > 0.0:
        deep *= _by_place(room.curve, centre)
    radius = halo.radius_mm(room.camera_height_mm, room.curve, height)
    return Dent(float(centre[0]), float(centre[1]), deep, radius)


def _by_place(curve: HaloCurve, place: Floats) -> float:
    return halo.by_place(curve, place[0] - WIDTH_MM / 2.0, place[1] - HEIGHT_MM / 2.0)


def _palm_radius_mm(room: Room) -> float:
    return PALM_RADIUS_MM * room.user.girth * room.user.size


def _places(points: Sequence[Dent | Glow]) -> Floats:
    return np.array([[point.x_mm, point.y_mm] for point in points])
