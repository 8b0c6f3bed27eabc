"""From posed hands to the halo they cast: which of their points hang low over the table.

Rule: places and heights only; `halo` has how deep a dent is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Finger
from halo_service.virtual import halo
from halo_service.virtual.boxes import Box
from halo_service.virtual.halo import Dent, Glow, HaloCurve, dent_field, glow_field
from halo_service.virtual.mesh import Floats
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.skeleton import PosedHand

Fade = tuple[float, float, float]
Image = NDArray[np.float32]

PALM_RADIUS_MM = 12.0
"""Flesh under the palm's bones, of a middling hand."""
PALM_SHARES = np.array([0.1, 0.5, 0.95])
"""Places on the palm's bones, from the wrist to the knuckle."""
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
    field: Callable[[Image, Image, Sequence[Box]], Image]
    """x and y on the surface, both (H, W), mm, and each place's part of these -> depth, mm."""


def halo_parts(room: Room, hands: Sequence[PosedHand], fade: Fade) -> list[HaloPart]:
    """The dents of all hands, and their glows; empty where no hand is low."""
    dents = [dent for hand in hands for dent in dents_of(room, hand, fade)]
    glows = [glow for hand in hands for glow in glows_of(room, hand, fade)]
    parts = []
    if dents:
        reach = DENT_REACH * max(dent.radius_mm * max(1.0, dent.stretch) for dent in dents)
        parts.append(HaloPart(_places(dents), reach, partial(dent_field, dents)))
    if glows:
        reach = halo.GLOW_FLESH_MM + halo.GLOW_REACH * max(glow.reach_mm for glow in glows)
        parts.append(HaloPart(_places(glows), reach, lambda x, y, _: glow_field(glows, x, y)))
    return parts


def dents_of(room: Room, hand: PosedHand, fade: Fade) -> list[Dent]:
    """Every fingertip and underside within the halo's reach."""
    centres, radii = _undersides(room, hand)
    height = np.maximum(0.0, -centres[:, 2] - radii)
    dents = []
    for number in np.flatnonzero(height < room.curve.onset_mm).tolist():
        if number < len(Finger) and hand.pointing(Finger(number)):
            dents.append(_tip(room, hand, Finger(number), fade))
        else:
            dents.append(_side(room, centres[number], float(height[number]), fade))
    return dents


def _undersides(room: Room, hand: PosedHand) -> tuple[Floats, Floats]:
    """(N, 3) centres and (N,) radii of what can hang low: the five tips first; mm."""
    middles = (hand.joints[:, :3] + hand.joints[:, 1:]) / 2.0
    thick = (hand.radii[:, :3] + hand.radii[:, 1:]) / 2.0
    palm = hand.palm[0] + PALM_SHARES[:, None] * (hand.palm[1:] - hand.palm[0])[:, None]
    centres = np.concatenate([hand.joints[:, 3], middles.reshape(-1, 3), palm.reshape(-1, 3)])
    flesh = np.full(palm.size // 3, _palm_radius_mm(room))
    return centres, np.concatenate([hand.radii[:, 3], thick.ravel(), flesh])


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


def _tip(room: Room, hand: PosedHand, finger: Finger, fade: Fade) -> Dent:
    """What a fingertip does; one that is curled in, its nail down, counts as any underside."""
    curve, pad = room.curve, hand.pad(finger)
    pitch, yaw = hand.pitch_yaw(finger)
    height, force = max(0.0, -float(pad[2])), hand.force_g[finger]
    deep = halo.depth(curve, height, force, fade) * halo.posture(pitch) * _by_place(curve, pad)
    radius = halo.radius_mm(room.camera_height_mm, curve, height, force)
    along = float(np.sin(np.radians(yaw))), -float(np.cos(np.radians(yaw)))
    x, y = (float(pad[k]) - curve.shift_mm * along[k] for k in (0, 1))
    return Dent(x, y, deep, radius, along, curve.stretch, curve.lopsided)


def _side(room: Room, centre: Floats, height_mm: float, fade: Fade) -> Dent:
    deep = halo.SIDE_WEIGHT * halo.depth(room.curve, height_mm, 0.0, fade)
    if room.curve.corner_fall > 0.0:
        deep *= _by_place(room.curve, centre)
    radius = halo.radius_mm(room.camera_height_mm, room.curve, height_mm)
    return Dent(float(centre[0]), float(centre[1]), deep, radius)


def _by_place(curve: HaloCurve, place: Floats) -> float:
    return halo.by_place(curve, place[0] - WIDTH_MM / 2.0, place[1] - HEIGHT_MM / 2.0)


def _palm_radius_mm(room: Room) -> float:
    return PALM_RADIUS_MM * room.user.girth * room.user.size


def _places(points: Sequence[Dent | Glow]) -> Floats:
    return np.array([[point.x_mm, point.y_mm] for point in points])
