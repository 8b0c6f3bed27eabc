"""Things in view: a mesh in the surface's frame with its reflectances.

Rule: shape and reflectance; where the light comes from is the images' business.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.virtual import appearance
from halo_service.virtual.mesh import Floats, Ints
from halo_service.virtual.skeleton import PosedHand, User


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One thing."""

    vertices: Floats
    """(V, 3) in the surface's frame, mm."""
    normals: Floats
    """(V, 3), unit, outward."""
    faces: Ints
    """(F, 3), anti-clockwise seen from outside."""
    infrared: NDArray[np.float32]
    """(V,) reflectance in the near infrared, 0 to 1."""
    colour: NDArray[np.float32]
    """(V, 3) reflectance, blue green red, 0 to 1."""
    offset_mm: NDArray[np.float32] | None = None
    """(V,) how much too far it reads: light that enters skin comes back late; None: nothing."""


def of_hand(user: User, hand: PosedHand) -> Body:
    """A hand as a thing that is seen."""
    return Body(
        hand.vertices + hand.normals * appearance.cloth_mm(user)[:, None],
        hand.normals,
        hand.faces,
        appearance.infrared(user),
        appearance.colour(user),
        appearance.offset_mm(user),
    )


def cup(x_mm: float, y_mm: float, radius_mm: float = 41.0, tall_mm: float = 95.0) -> Body:
    """A mug without its handle, closed on top."""
    around = np.linspace(0.0, 2.0 * np.pi, 37)[:-1]
    outline = np.column_stack([np.cos(around), np.sin(around)]) * radius_mm + (x_mm, y_mm)
    return _prism(outline, tall_mm, 0.55, (0.55, 0.35, 0.2))


def block(x_mm: float, y_mm: float, width_mm: float, long_mm: float, tall_mm: float) -> Body:
    """A pale block on the table, from its far left corner on."""
    outline = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    outline = outline * (width_mm, long_mm) + (x_mm, y_mm)
    return _prism(outline, tall_mm, 0.6, (0.6, 0.6, 0.6))


def wedge(x_mm: float, y_mm: float, yaw_deg: float) -> Body:
    """The printed 45 degree part on which a calibrating finger rests, sharp end at the pad.

    22 mm wide, 30 mm long and high: chosen, the paper gives the angle alone (4.3.5).
    """
    near, long, half = 7.0, 37.0, 11.0
    corners = np.array(
        [
            (-half, near, 0.0),
            (half, near, 0.0),
            (-half, long, 0.0),
            (half, long, 0.0),
            (-half, long, near - long),
            (half, long, near - long),
        ]
    )
    yaw = np.radians(yaw_deg)
    turn = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1.0]])
    corners = corners @ turn + (x_mm, y_mm, 0.0)
    quads = ((0, 4, 5, 1), (2, 3, 5, 4), (0, 1, 3, 2))
    triangles = [(0, 2, 4), (1, 5, 3)]
    for a, b, c, d in quads:
        triangles += [(a, b, c), (a, c, d)]
    return _flat_shaded(corners, np.array(triangles), 0.7, (0.75, 0.75, 0.75))


def _prism(outline: Floats, tall_mm: float, infrared: float, colour: tuple[float, ...]) -> Body:
    """An upright prism on the table, (N, 2) clockwise as x right, y down are drawn."""
    count = len(outline)
    low = np.column_stack([outline, np.zeros(count)])
    high = np.column_stack([outline, np.full(count, -tall_mm)])
    middle = np.append(outline.mean(axis=0), -tall_mm)[None]
    after = np.roll(np.arange(count), -1)
    here = np.arange(count)
    faces = np.concatenate(
        [
            np.column_stack([here, after, after + count]),
            np.column_stack([here, after + count, here + count]),
            np.column_stack([here + count, after + count, np.full(count, 2 * count)]),
        ]
    )
    return _flat_shaded(np.concatenate([low, high, middle]), faces, infrared, colour)


def _flat_shaded(corners: Floats, faces: Ints, infrared: float, colour: tuple[float, ...]) -> Body:
    """Give each face corners of its own, so that edges stay sharp; turn all faces outward."""
    vertices = corners[faces].reshape(-1, 3)
    across = np.cross(vertices[1::3] - vertices[::3], vertices[2::3] - vertices[::3])
    outward = vertices.reshape(-1, 3, 3).mean(axis=1) - corners.mean(axis=0)
    flip = np.einsum("ij,ij->i", across, outward) < 0.0
    new = np.arange(len(vertices)).reshape(-1, 3)
    new[flip] = new[flip][:, ::-1]
    normals = np.where(flip[:, None], -across, across)
    normals = np.repeat(normals / np.linalg.norm(normals, axis=1, keepdims=True), 3, axis=0)
    count = len(vertices)
    return Body(
        vertices,
        normals,
        new,
        np.full(count, infrared, np.float32),
        np.tile(np.array(colour, np.float32), (count, 1)),
    )
