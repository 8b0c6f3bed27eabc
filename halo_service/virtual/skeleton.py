"""A hand's skeleton and skin: from joint angles to every vertex.

Rule: pure geometry, in the surface's frame (x right, y towards the user, z down into the
surface; height is -z). `hand` has the angles of a hand.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from halo_service.values import Finger, Side
from halo_service.virtual.anatomy import ARM, BONES, PLANS, bone_of, hand_mesh, joints, nail_count
from halo_service.virtual.mesh import Floats, Ints

Angles = tuple[float, float, float]


def about_x(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_z(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True)
class User:
    """The person: size, skin, habits."""

    size: float = 1.0
    """Length of the hand in that of the table in `anatomy`."""
    girth: float = 1.0
    """Thickness of its flesh, likewise, before `size`."""
    pad_g: float = 90.0
    """Force at which the pad has given way by 1 - 1/e of what it can, grams. Fingertips are soft
    at first and stiffen (Serina et al. 1997: most of the travel is used up at 1 N = 102 g)."""
    pad_mm: float = 2.2
    """How far the pad can give way, mm; about 2 mm at 1 N (Serina et al. 1997)."""
    skin: float = 0.55
    """Reflectance of the skin in the near infrared; 0.4 to 0.65 over all skin types, nearly
    blind to the melanin that the eye sees (chosen within published spectra at 850 nm)."""
    tone: tuple[float, float, float] = (0.36, 0.48, 0.70)
    """Colour of the skin, blue green red, 0 to 1."""
    skin_offset_mm: float = 9.0
    """How much too far skin reads: infrared light enters it and comes back late
    (Azure-Kinect-Sensor-SDK #1341: 8 to 15 mm, by person)."""
    nail_mm: float = 10.0
    """Visible length of the nails."""
    sleeve_mm: float | None = None
    """Where a sleeve begins, from the wrist towards the elbow; None: bare arm."""
    curl: float = 1.0
    """How far a pointing hand's other fingers are drawn in: 0 they hang down to just above the
    table, 1 near the palm (5.1)."""
    thumb_out: float = 0.0
    """How far a pointing hand's thumb is spread: 0 along the index finger, 1 far out."""
    nail_over_mm: float = 0.0
    """How far the nails reach beyond the fingertips."""
    sleeve_infrared: float = 0.45
    """Reflectance of the sleeve. Dark dyes are bright in the near infrared: chosen."""
    rings: tuple[Finger, ...] = ()
    """Fingers with a ring on their first segment."""


@dataclass(frozen=True, slots=True)
class FingerPose:
    """Where one fingertip shall be: a pointing hand in six numbers."""

    x_mm: float
    y_mm: float
    """The pad's lowest point on the surface."""
    height_mm: float
    """Of that point above the surface; 0 in contact."""
    force_g: float = 0.0
    """0 unless in contact."""
    pitch_deg: float = 45.0
    """Of the last segment: 0 lying flat, 90 upright."""
    yaw_deg: float = 0.0
    """Of the last segment: 0 pointing to the far edge, positive clockwise from above."""


@dataclass(frozen=True, slots=True, eq=False)
class HandPose:
    """A hand with every joint set."""

    side: Side
    surface_from_hand: Floats
    """(4, 4), mm; the hand's frame is that of `anatomy`, mirrored for a left hand."""
    flexion: tuple[Angles, ...]
    """Five fingers, three joints each, degrees downwards."""
    spread: tuple[float, ...]
    """Five fingers, degrees away from rest, positive towards the little finger."""
    arm_pitch_deg: float = 0.0
    """The wrist: how much steeper the forearm rises than the hand, degrees."""
    force_g: tuple[float, ...] = (0.0,) * 5
    """What each finger presses with; 0 where it does not touch."""


@dataclass(frozen=True, slots=True, eq=False)
class PosedHand:
    """A hand in place: its skin, and the truth about its fingers."""

    side: Side
    vertices: Floats
    """(V, 3) in the surface's frame, mm."""
    normals: Floats
    """(V, 3), unit."""
    faces: Ints
    """(F, 3), anti-clockwise seen from outside."""
    joints: Floats
    """(5, 4, 3) each finger's three joints and the centre of its tip's sphere, mm."""
    radii: Floats
    """(5, 4) thickness at those, mm."""
    palm: Floats
    """(5, 3) the wrist and the four knuckles, mm: a palm rests on the flesh between them."""
    force_g: tuple[float, ...]
    velocity_mm_s: Floats
    """(3,) of the hand as a whole: what smears it in a long exposure."""

    def pointing(self, finger: Finger) -> bool:
        """Whether a finger is stretched out far enough to point; curled ones are not, and a
        thumb only when the whole hand is open or it presses."""
        if finger is Finger.THUMB and self.force_g[finger] == 0.0:
            return all(self.pointing(f) for f in (Finger.MIDDLE, Finger.RING, Finger.LITTLE))
        first, last = (self.joints[finger, k + 1] - self.joints[finger, k] for k in (0, 2))
        bend = np.arccos(np.clip(_unit(first) @ _unit(last), -1.0, 1.0))
        return bool(np.degrees(bend) < POINTING_DEG)

    def pad(self, finger: Finger) -> Floats:
        """(3,) the lowest point of a fingertip; z is pressed into the surface in contact."""
        below = np.array([0.0, 0.0, self.radii[finger, 3]])
        return np.asarray(self.joints[finger, 3] + below, dtype=np.float64)

    def pitch_yaw(self, finger: Finger) -> tuple[float, float]:
        """Degrees, of the last segment."""
        d = self.joints[finger, 3] - self.joints[finger, 2]
        pitch = np.degrees(np.arctan2(d[2], np.hypot(d[0], d[1])))
        return float(pitch), float(np.degrees(np.arctan2(d[0], -d[1])))


NAIL_CLEAR_MM = -0.2
"""A nail lies at least so high above the table, chosen."""
POINTING_DEG = 95.0
"""Bend between a finger's first and last segment below which it points; chosen."""


def indentation_mm(user: User, force_g: float) -> float:
    """How far the pad has flattened under a force, mm."""
    return user.pad_mm * (1.0 - float(np.exp(-max(force_g, 0.0) / user.pad_g)))


def tip_of(user: User, pose: HandPose, finger: Finger) -> Floats:
    """(3,) the lowest point of a fingertip, as `PosedHand.pad` gives it, without the skin."""
    tip = joints_of(bones_of(pose))[finger, 3] * user.size
    if pose.side is Side.LEFT:
        tip[0] = -tip[0]
    low = pose.surface_from_hand[:3, :3] @ tip + pose.surface_from_hand[:3, 3]
    low[2] += PLANS[finger].radii[3] * user.girth * user.size
    return np.asarray(low, dtype=np.float64)


def posed(user: User, pose: HandPose, velocity_mm_s: Floats | None = None) -> PosedHand:
    """Bend the skin over the bones and put it into the surface's frame."""
    mesh = hand_mesh(user.girth, user.nail_over_mm)
    bones = bones_of(pose)
    hand = _surface_from_rest(user, pose)
    # One row for each number of a vertex's transform: sums over whole rows are the fastest.
    mix = (hand @ bones)[:, :3].reshape(BONES, 12).T @ mesh.pull
    vertices, normals = np.empty((2, 3, mix.shape[1]))
    for axis, (a, b, c, shift) in enumerate(mix.reshape(3, 4, -1)):
        vertices[axis] = a * mesh.rows[0] + b * mesh.rows[1] + c * mesh.rows[2] + shift
        normals[axis] = a * mesh.rows[3] + b * mesh.rows[4] + c * mesh.rows[5]
    x, y, z = normals
    normals /= np.sqrt(x * x + (y * y + z * z))
    if user.nail_over_mm > 0.0:  # a nail that meets the table goes no deeper than the pad
        nails = vertices[2, -nail_count() :]
        np.minimum(nails, NAIL_CLEAR_MM, out=nails)
    palm = np.array([[0.0, 0.0, 0.0], *(PLANS[f].root for f in list(Finger)[1:])])
    return PosedHand(
        pose.side,
        vertices.T,
        normals.T,
        mesh.faces if pose.side is Side.RIGHT else mesh.faces[:, ::-1],
        joints_of(bones) @ hand[:3, :3].T + hand[:3, 3],
        np.array([PLANS[finger].radii for finger in Finger]) * user.girth * user.size,
        palm @ hand[:3, :3].T + hand[:3, 3],
        pose.force_g,
        np.zeros(3) if velocity_mm_s is None else velocity_mm_s,
    )


def _surface_from_rest(user: User, pose: HandPose) -> Floats:
    """(4, 4) from the hand's frame in the table's size to the surface; it mirrors a left hand."""
    size = user.size
    scaled = np.diag([-size if pose.side is Side.LEFT else size, size, size, 1.0])
    return np.asarray(pose.surface_from_hand @ scaled, dtype=np.float64)


def bones_of(pose: HandPose) -> Floats:
    """(BONES, 4, 4) what carries rest points of each bone to their place in the hand's frame.

    Not to be written to: a frame asks for the same joint angles several times.
    """
    return _bones(pose.flexion, pose.spread, pose.arm_pitch_deg)


@functools.lru_cache(maxsize=64)
def _bones(flexion: tuple[Angles, ...], spread: tuple[float, ...], arm_pitch_deg: float) -> Floats:
    bones = np.tile(np.eye(4), (BONES, 1, 1))
    bones[ARM] = _hinges(np.zeros((1, 3)), about_x(-np.radians(arm_pitch_deg))[None])[0]
    # All five fingers at once: bend each joint about the finger's own sideways axis.
    flex = -np.radians(np.array(flexion))
    bends = _AHEAD[:, None] @ _turns_about_x(flex) @ _AHEAD.transpose(0, 2, 1)[:, None]
    spreads = np.stack([about_z(np.radians(angle)) for angle in spread])
    bends[:, 0] = spreads @ bends[:, 0]
    carried = _hinges(_REST[:, 0], bends[:, 0])
    bones[2::3] = carried
    for segment in (1, 2):
        carried = carried @ _hinges(_REST[:, segment], bends[:, segment])
        bones[2 + segment :: 3] = carried
    bones.flags.writeable = False
    return bones


def joints_of(bones: Floats) -> Floats:
    """(5, 4, 3) each finger's three joints and its tip's centre, in the hand's frame."""
    carriers = bones[_CARRIERS]
    return np.asarray(
        np.einsum("fjik,fjk->fji", carriers[..., :3, :3], _REST) + carriers[..., :3, 3]
    )


_REST = np.stack([joints(finger) for finger in Finger])
_AHEAD = np.stack([about_z(np.radians(PLANS[finger].yaw_deg)) for finger in Finger])
_CARRIERS = np.array([[bone_of(finger, segment) for segment in (0, 1, 2, 2)] for finger in Finger])


def _turns_about_x(angles: Floats) -> Floats:
    """(..., 3, 3)."""
    turns = np.zeros((*angles.shape, 3, 3))
    turns[..., 0, 0] = 1.0
    turns[..., 1, 1] = turns[..., 2, 2] = np.cos(angles)
    turns[..., 2, 1] = np.sin(angles)
    turns[..., 1, 2] = -turns[..., 2, 1]
    return turns


def _hinges(points: Floats, rotations: Floats) -> Floats:
    """(N, 4, 4) turns about points."""
    transforms = np.zeros((len(points), 4, 4))
    transforms[:, 3, 3] = 1.0
    transforms[:, :3, :3] = rotations
    transforms[:, :3, 3] = points - np.einsum("nij,nj->ni", rotations, points)
    return transforms


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector), dtype=np.float64)
