"""Skin over bones: tapered capsules, melted together, meshed once, bent by linear blend skinning.

Rule: geometry only. `anatomy` has the shape of a hand, `hand` its postures.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
DistanceField = Callable[[Floats], Floats]
"""Maps (N, 3) points to (N,) signed distances, mm, negative inside."""


@dataclass(frozen=True, slots=True)
class Capsule:
    """A bone with flesh: the convex hull of two spheres."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    """Centres of the spheres, mm."""
    start_radius: float
    end_radius: float
    """mm."""
    bone: int
    """The joint frame that carries it."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed triangle mesh in its rest pose, and which bone pulls at which vertex."""

    vertices: Floats
    """(V, 3), mm."""
    normals: Floats
    """(V, 3), unit, outward."""
    faces: Ints
    """(F, 3) vertex indices, anti-clockwise seen from outside."""
    weights: Floats
    """(V, B), each row adds up to 1."""

    @functools.cached_property
    def pull(self) -> Floats:
        """(B, V) the weights, row by row."""
        return np.ascontiguousarray(self.weights.T)

    @functools.cached_property
    def rows(self) -> Floats:
        """(6, V) x, y and z of the vertices, then of the normals."""
        return np.ascontiguousarray(np.column_stack([self.vertices, self.normals]).T)


def in_frame(frame_from_mesh: Floats, points: Floats) -> Floats:
    """(N, 3) points in another frame, by a (4, 4) transform; x, y and z lie one after the other."""
    moved = frame_from_mesh[:3, :3] @ points.T + frame_from_mesh[:3, 3:]
    return np.asarray(moved.T, dtype=np.float64)


def capsule_distances(capsules: list[Capsule], points: Floats) -> Floats:
    """(N, C) signed distances of (N, 3) points to each capsule, mm."""
    columns = []
    for capsule in capsules:
        start, end = np.array(capsule.start), np.array(capsule.end)
        axis = end - start
        along = np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)
        radius = capsule.start_radius + along * (capsule.end_radius - capsule.start_radius)
        x, y, z = (points - start - along[:, None] * axis).T
        columns.append(np.sqrt(x * x + y * y + z * z) - radius)
    return np.column_stack(columns)


def smooth_union(distances: Floats, blend_mm: float) -> Floats:
    """Melt (N, C) distances into (N,): the minimum, rounded off where two are about equal."""
    nearest = distances.min(axis=1, keepdims=True)
    heap = np.exp((nearest - distances) / blend_mm).sum(axis=1)
    return np.asarray(nearest[:, 0] - blend_mm * np.log(heap), dtype=np.float64)


def gradient(field: DistanceField, points: Floats, step_mm: float = 0.05) -> Floats:
    """(N, 3) central differences of a distance field: the outward direction."""
    columns = []
    for axis in np.eye(3) * step_mm:
        columns.append((field(points + axis) - field(points - axis)) / (2.0 * step_mm))
    return np.column_stack(columns)


def surface_nets(field: DistanceField, axes: tuple[Floats, Floats, Floats]) -> tuple[Floats, Ints]:
    """Mesh the zero of a distance field on a grid that may be uneven.

    One vertex in each cell that the surface crosses, pulled onto the surface; one quad (two
    triangles) across each grid edge that it cuts. Needs no table of cases, and its triangles are
    rounder than those of marching cubes. Returns (V, 3) vertices and (F, 3) faces.
    """
    shape = tuple(len(axis) for axis in axes)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = (field(grid) < 0.0).reshape(shape)
    corners = [
        inside[i : shape[0] - 1 + i, j : shape[1] - 1 + j, k : shape[2] - 1 + k]
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    ]
    filled = np.sum(corners, axis=0)
    cells = np.argwhere((filled > 0) & (filled < 8))
    number = np.full(filled.shape, -1)
    number[tuple(cells.T)] = np.arange(len(cells))

    middles = [(axis[1:] + axis[:-1]) / 2.0 for axis in axes]
    vertices = np.column_stack([middles[d][cells[:, d]] for d in range(3)])
    for _ in range(4):  # Newton's steps along the gradient; four leave less than 0.01 mm.
        slope = gradient(field, vertices)
        length = np.maximum(np.einsum("ij,ij->i", slope, slope), 1e-9)
        vertices = vertices - slope * (field(vertices) / length)[:, None]
    return vertices, _net(inside, number)


def _net(inside: NDArray[np.bool_], number: Ints) -> Ints:
    """Join the four cells around each cut grid edge; inside on the low side turns one way."""
    faces = []
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        low = np.take(inside, range(inside.shape[d] - 1), axis=d)
        high = np.take(inside, range(1, inside.shape[d]), axis=d)
        edges = np.argwhere(low != high)
        edges = edges[(edges[:, u] > 0) & (edges[:, v] > 0)]
        leaves = low[tuple(edges.T)]
        ring = []
        for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = edges.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            ring.append(number[tuple(cell.T)])
        a, b, c, e = ring[0], ring[1], ring[2], ring[3]
        b, e = np.where(leaves, b, e), np.where(leaves, e, b)
        faces += [np.column_stack([a, b, c]), np.column_stack([a, c, e])]
    return np.concatenate(faces)
