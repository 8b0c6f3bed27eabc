"""From a posed hand to the dents it makes: which of its points hang low over the table.

Rule: places and heights only; `halo` has how deep a dent is.
"""

from __future__ import annotations

from halo_service.values import Finger
from halo_service.virtual import halo
from halo_service.virtual.halo import Dent
from halo_service.virtual.mesh import Floats
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.skeleton import PosedHand

Fade = tuple[float, float, float]

PALM_RADIUS_MM = 12.0
"""Flesh under the palm's bones, of a middling hand."""


def dents_of(room: Room, hand: PosedHand, fade: Fade) -> list[Dent]:
    """Every fingertip and underside within the halo's reach."""
    dents = [_tip(room, hand, finger, fade) for finger in Finger]
    for finger in Finger:
        bones, radii = hand.joints[finger], hand.radii[finger]
        for segment in range(3):
            middle = (bones[segment] + bones[segment + 1]) / 2.0
            dents.append(_side(room, middle, (radii[segment] + radii[segment + 1]) / 2.0, fade))
    radius = PALM_RADIUS_MM * room.user.girth * room.user.size
    for knuckle in hand.palm[1:]:
        for share in (0.1, 0.5, 0.95):
            place = hand.palm[0] + share * (knuckle - hand.palm[0])
            dents.append(_side(room, place, radius, fade))
    return [dent for dent in dents if dent is not None]


def _tip(room: Room, hand: PosedHand, finger: Finger, fade: Fade) -> Dent | None:
    """What a fingertip does; one that is curled in, its nail down, counts as any underside."""
    pad = hand.pad(finger)
    pitch, _ = hand.pitch_yaw(finger)
    if not hand.pointing(finger):
        return _side(room, hand.joints[finger, 3], hand.radii[finger, 3], fade)
    height = max(0.0, -pad[2])
    if height >= room.curve.onset_mm:
        return None
    deep = halo.depth(room.curve, height, hand.force_g[finger], fade) * halo.posture(pitch)
    deep *= halo.by_place(room.curve, pad[0] - WIDTH_MM / 2.0, pad[1] - HEIGHT_MM / 2.0)
    return _dent(room, pad, deep)


def _side(room: Room, centre: Floats, radius_mm: float, fade: Fade) -> Dent | None:
    height = max(0.0, -float(centre[2]) - radius_mm)
    if height >= room.curve.onset_mm:
        return None
    return _dent(room, centre, halo.SIDE_WEIGHT * halo.depth(room.curve, height, 0.0, fade))


def _dent(room: Room, place: Floats, deep: float) -> Dent:
    radius = halo.radius_mm(room.camera_height_mm)
    return Dent(float(place[0]), float(place[1]), deep, radius)
