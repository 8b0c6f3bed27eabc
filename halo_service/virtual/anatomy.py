"""The shape of a hand: bones, their lengths and their flesh.

Rule: a table, and what follows from it. The hand lies flat, palm down, in a frame like the
surface's: x right, y towards the user, z down; fingers point to -y, the origin is the wrist.
A right hand's thumb is at -x. Lengths and radii are of a middling adult hand (187 mm from wrist
to middle fingertip, about the mean of men and women in common anthropometric surveys): chosen.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass

import numpy as np

from halo_service.values import Finger
from halo_service.virtual.mesh import (
    Capsule,
    Floats,
    Mesh,
    capsule_distances,
    gradient,
    smooth_union,
    surface_nets,
)

ARM, PALM = 0, 1
"""Bones 0 and 1; then three for each finger, thumb first: `2 + 3 * finger + segment`."""
BONES = 17
BLEND_MM = 1.6
"""How softly neighbouring flesh melts together; chosen, fingers stay apart and knuckles round."""
CELL_MM = 5.0
"""Mesh cells on the hand. Much coarser, and the hand tracker no longer sees a hand."""
ARM_CELL_MM = 14.0
UPPER_ARM_CELL_MM = 40.0
FOREARM_MM, ARM_MM = 300.0, 900.0
"""Where the elbow is and where the arm ends: out of view even of a camera 1 m up."""
NAIL_BACK, NAIL_WIDTH, NAIL_THICK_MM = 0.7, 0.75, 0.8
"""How far behind the fingertip's axis a long nail lies and half its width, in radii of the tip,
and its thickness; chosen."""


@dataclass(frozen=True, slots=True)
class FingerPlan:
    """One finger at rest."""

    root: tuple[float, float, float]
    """Its first joint, mm."""
    yaw_deg: float
    """Where it points at rest, clockwise from above; the thumb's is far off."""
    lengths: tuple[float, float, float]
    """Three segments, mm; the last ends at the centre of the tip's sphere."""
    radii: tuple[float, float, float, float]
    """At the three joints and at the tip, mm."""


PLANS = {
    Finger.THUMB: FingerPlan((-21, -20, 7), -42, (42, 33, 23), (15, 12.0, 10.0, 8.2)),
    Finger.INDEX: FingerPlan((-25, -88, 0), -5, (44, 26, 17.5), (10.8, 9.1, 8.0, 6.8)),
    Finger.MIDDLE: FingerPlan((-4, -92, -2), 0, (48, 30, 18.5), (11.0, 9.3, 8.2, 7.0)),
    Finger.RING: FingerPlan((16, -86, -1), 5, (44, 28, 18.5), (10.4, 8.8, 7.8, 6.6)),
    Finger.LITTLE: FingerPlan((34, -76, 3), 11, (34, 20, 16.0), (9.4, 7.6, 6.8, 5.8)),
}

WRISTS = {Finger.INDEX: -15.0, Finger.MIDDLE: -5.0, Finger.RING: 6.0, Finger.LITTLE: 15.0}
"""Where the palm's four bones begin, x in mm."""


def bone_of(finger: Finger, segment: int) -> int:
    """The bone that carries a segment, 0 (at the palm) to 2 (with the nail)."""
    return 2 + 3 * int(finger) + segment


def finger_direction(yaw_deg: float) -> Floats:
    """Unit vector in the plane of the hand."""
    yaw = np.radians(yaw_deg)
    return np.array([np.sin(yaw), -np.cos(yaw), 0.0])


def joints(finger: Finger) -> Floats:
    """(4, 3) the three joints of a finger at rest and the centre of its tip, mm."""
    plan = PLANS[finger]
    steps = np.concatenate([[0.0], np.cumsum(plan.lengths)])
    places = np.array(plan.root) + steps[:, None] * finger_direction(plan.yaw_deg)
    return np.asarray(places, dtype=np.float64)


def capsules(girth: float) -> list[Capsule]:
    """Every bone with its flesh, `girth` times as thick as the table says."""
    flesh = []
    for finger, plan in PLANS.items():
        places = joints(finger)
        for segment in range(3):
            start, end = places[segment], places[segment + 1]
            radius = plan.radii[segment] * girth, plan.radii[segment + 1] * girth
            flesh.append(Capsule(tuple(start), tuple(end), *radius, bone_of(finger, segment)))
    for finger, x in WRISTS.items():
        root = PLANS[finger].root
        flesh.append(Capsule((x, 0.0, 0.0), root, 15.5 * girth, 12.0 * girth, PALM))
    for side in (-1.0, 1.0):
        elbow = (side * 20.0, FOREARM_MM, 0.0)
        flesh.append(Capsule((side * 11.0, 4.0, 0.0), elbow, 17.0, 31.0, ARM))
        flesh.append(Capsule(elbow, (side * 20.0, ARM_MM, 0.0), 31.0, 36.0, ARM))
    return flesh


@functools.lru_cache(maxsize=8)
def hand_mesh(girth: float, nail_over_mm: float = 0.0) -> Mesh:
    """The right hand at rest, with skinning weights; the vertices of long nails come last."""
    skin = _skin_mesh(girth)
    if nail_over_mm == 0.0:
        return skin
    parts = [skin, *(_long_nail(finger, girth, nail_over_mm) for finger in Finger)]
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.asfortranarray(
            np.concatenate([part.faces + start for part, start in zip(parts, first, strict=False)])
        ),
        np.concatenate([part.weights for part in parts]),
    )


def nail_count() -> int:
    """Vertices of the five long nails."""
    return len(Finger) * len(_CORNERS)


_CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
_CORNER_FACES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip


def _long_nail(finger: Finger, girth: float, over_mm: float) -> Mesh:
    """A thin plate from the nail bed to `over_mm` beyond the fingertip."""
    plan, tip = PLANS[finger], joints(finger)[3]
    radius = plan.radii[3] * girth
    along = finger_direction(plan.yaw_deg)
    across = np.array([-along[1], along[0], 0.0])
    low, thick = NAIL_BACK * radius, NAIL_THICK_MM
    vertices = (
        tip
        + _CORNERS[:, :1] * across * NAIL_WIDTH * radius
        + _CORNERS[:, 1:2] * along * (radius + over_mm)
        - np.array([0.0, 0.0, 1.0]) * (low + _CORNERS[:, 2:] * thick)
    )
    normals = vertices - vertices.mean(axis=0)
    normals = np.array([0.0, 0.0, -1.0]) + 0.2 * normals / np.linalg.norm(normals, axis=1)[:, None]
    weights = np.zeros((len(vertices), BONES))
    weights[:, bone_of(finger, 2)] = 1.0
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(vertices, normals / lengths, _CORNER_FACES, weights)


@functools.lru_cache(maxsize=4)
def _skin_mesh(girth: float) -> Mesh:
    """Skin over flesh over bones; built in about half a second."""
    flesh = capsules(girth)

    def field(points: Floats) -> Floats:
        return smooth_union(capsule_distances(flesh, points), BLEND_MM * 2.0)

    axes = (
        np.arange(-112.0, 72.0, CELL_MM),
        np.concatenate(
            [
                np.arange(-208.0, 24.0, CELL_MM),
                np.arange(24.0, FOREARM_MM, ARM_CELL_MM),
                np.arange(FOREARM_MM, ARM_MM + 60.0, UPPER_ARM_CELL_MM),
            ]
        ),
        np.arange(-46.0, 46.0, CELL_MM),
    )
    vertices, faces = surface_nets(field, axes)
    normals = gradient(field, vertices)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(vertices, normals, np.asfortranarray(faces), skin_weights(flesh, vertices))


def skin_weights(flesh: list[Capsule], vertices: Floats) -> Floats:
    """(V, BONES): a vertex follows the nearest bone and, near a joint, that bone's neighbours."""
    distances = capsule_distances(flesh, vertices)
    by_bone = np.full((len(vertices), BONES), np.inf)
    for column, capsule in enumerate(flesh):
        by_bone[:, capsule.bone] = np.minimum(by_bone[:, capsule.bone], distances[:, column])
    nearest = by_bone.argmin(axis=1)
    pull = np.exp(-np.maximum(by_bone - by_bone.min(axis=1, keepdims=True), 0.0) / 2.0)
    pull *= _neighbours()[nearest]
    return np.asarray(pull / pull.sum(axis=1, keepdims=True), dtype=np.float64)


def _neighbours() -> Floats:
    """(BONES, BONES) 1 where two bones share a joint, so that no finger drags its neighbour."""
    share = np.eye(BONES)
    pairs = [(ARM, PALM)]
    for finger in Finger:
        chain = [PALM, *(bone_of(finger, segment) for segment in range(3))]
        pairs += itertools.pairwise(chain)
    for a, b in pairs:
        share[a, b] = share[b, a] = 1.0
    return share
