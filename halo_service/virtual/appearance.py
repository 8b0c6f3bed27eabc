"""What a hand looks like: skin, nails, sleeve, vertex by vertex.

Rule: reflectances only, 0 to 1; light is the images' business.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Finger
from halo_service.virtual.anatomy import PLANS, finger_direction, hand_mesh, joints, nail_count
from halo_service.virtual.mesh import Mesh
from halo_service.virtual.skeleton import User

RING_INFRARED, RING_COLOUR = 0.85, (0.35, 0.62, 0.78)
"""A gold ring, matt; chosen."""
RING_AT, RING_HALF_MM = 0.45, 4.0
"""Where on the first segment, and half its width: the mesh has cells of 5 mm."""
NAIL_SHINE = 1.12
"""A nail's infrared against skin's, chosen."""
NAIL_COLOUR = (0.72, 0.74, 0.92)
CLOTH_COLOUR = (0.35, 0.22, 0.18)
"""A blue sleeve, chosen."""
CLOTH_MM = 6.0
"""Distance of a sleeve from the arm, chosen."""

Reflectance = NDArray[np.float32]


@functools.lru_cache(maxsize=8)
def infrared(user: User) -> Reflectance:
    """(V,) reflectance in the near infrared."""
    skin = np.full(len(_mesh(user).vertices), user.skin)
    skin[_nails(user)] *= NAIL_SHINE
    skin[_ringed(user)] = RING_INFRARED
    skin[_sleeve(user)] = user.sleeve_infrared
    return skin.astype(np.float32)


@functools.lru_cache(maxsize=8)
def colour(user: User) -> Reflectance:
    """(V, 3) blue, green, red."""
    skin = np.tile(np.array(user.tone), (len(_mesh(user).vertices), 1))
    nails = _nails(user)
    skin[nails] = 0.6 * skin[nails] + 0.4 * np.array(NAIL_COLOUR)
    skin[_ringed(user)] = RING_COLOUR
    skin[_sleeve(user)] = CLOTH_COLOUR
    return np.asfortranarray(skin.astype(np.float32))


@functools.lru_cache(maxsize=8)
def offset_mm(user: User) -> Reflectance:
    """(V,) how much too far it reads, mm: skin does, cloth reads right
    (Azure-Kinect-Sensor-SDK #1341)."""
    return (user.skin_offset_mm * ~_sleeve(user)).astype(np.float32)


@functools.lru_cache(maxsize=8)
def cloth_mm(user: User) -> Reflectance:
    """(V,) distance of the cloth from the skin."""
    return (CLOTH_MM * _sleeve(user)).astype(np.float32)


def _mesh(user: User) -> Mesh:
    return hand_mesh(user.girth, user.nail_over_mm)


def _ringed(user: User) -> NDArray[np.bool_]:
    """(V,) what is under a ring."""
    vertices = _mesh(user).vertices
    ringed = np.zeros(len(vertices), dtype=np.bool_)
    for finger in user.rings:
        start, end = joints(finger)[:2]
        axis = (end - start) / np.linalg.norm(end - start)
        middle = start + RING_AT * (end - start)
        along = (vertices - middle) @ axis
        aside = np.linalg.norm(vertices - middle - along[:, None] * axis, axis=1)
        radius = PLANS[finger].radii[0] * user.girth
        ringed |= (np.abs(along) < RING_HALF_MM) & (aside < 1.35 * radius)
    return ringed


def _sleeve(user: User) -> NDArray[np.bool_]:
    """(V,) what is inside a sleeve."""
    along_arm = _mesh(user).vertices[:, 1]
    begins = np.inf if user.sleeve_mm is None else user.sleeve_mm
    return np.asarray(along_arm > begins, dtype=np.bool_)


def _nails(user: User) -> NDArray[np.bool_]:
    """(V,) where the back of a last segment faces up, near its end."""
    mesh = _mesh(user)
    nails = np.zeros(len(mesh.vertices), dtype=np.bool_)
    for finger in Finger:
        plan = PLANS[finger]
        tip, along = joints(finger)[3], finger_direction(plan.yaw_deg)
        from_end = (tip + along * plan.radii[3] * user.girth - mesh.vertices) @ along
        on_finger = np.linalg.norm(mesh.vertices - tip, axis=1) < 1.6 * user.nail_mm
        on_back = mesh.normals[:, 2] < -0.6
        nails |= on_finger & on_back & (from_end > 1.5) & (from_end < user.nail_mm)
    if user.nail_over_mm > 0.0:
        nails[-nail_count() :] = True
    return nails
