"""Triangles to pixels: which point of which mesh a camera sees in each pixel.

Rule: geometry only; what the pixel then measures is the sensor's business. Exact at pixel
centres, through the lens's distortion (an edge between two projected vertices is straight, which
at a few millimetres a triangle is off by less than a hundredth of a pixel). Faces are painted
from far to near by their middles: right for small triangles of bodies that do not cut each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.virtual.mesh import Floats, Ints

Pixels = NDArray[np.float32]
NEAR_MM = 50.0
"""What comes closer to the lens is not drawn."""
WIDEST = 1.6
"""Nor what lies farther off the axis than this times its depth: 58 degrees, where the corners of
both lenses' images are at 50. A lens model holds no farther, and folds an arm that is out of view
back into the image."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What of a mesh is seen, pixel by pixel."""

    pixel: Ints
    """(N,) flat pixel numbers, row * width + column, each once."""
    corners: Ints
    """(N, 3) the vertices of the triangle seen there."""
    share: Pixels
    """(N, 3) barycentric shares of these."""

    def mix(self, per_vertex: Pixels) -> Pixels:
        """(N, K) from (V, K): a vertex quantity at each pixel."""
        a, b, c = (
            per_vertex.take(self.corners[:, k], axis=0) * self.share[:, k : k + 1] for k in range(3)
        )
        return np.asarray(a + b + c, dtype=np.float32)


_NOTHING = Seen(np.empty(0, np.int64), np.empty((0, 3), np.int64), np.empty((0, 3), np.float32))


def rasterise(lens: Lens, points: Floats, faces: Ints) -> Seen:
    """See a closed mesh, (V, 3) in the camera's frame, through a lens; the nearest face wins."""
    px = lens.project(points).astype(np.float32)
    in_front = np.hypot(points[:, 0], points[:, 1]) < WIDEST * points[:, 2]
    faces = _towards(px, np.where(in_front, points[:, 2], 0.0).astype(np.float32), faces)
    face, row, first, last = _spans(lens, px, faces)
    if len(row) == 0:
        return _NOTHING
    start, count = row * lens.width + first, last - first + 1
    lowest, highest = int(start.min()), int((start + count).max())
    winner = np.full(highest - lowest, -1, np.int32)
    # From far to near: the nearest stays.
    winner[_runs(start - lowest, count)] = np.repeat(np.arange(len(row), dtype=np.int32), count)
    pixel = np.flatnonzero(winner >= 0)
    span = winner.take(pixel).astype(np.int64)
    pixel += lowest
    corners, y = faces.take(face.take(span), axis=0), row.take(span)
    return Seen(pixel, corners, _shares(px, corners, pixel - y * lens.width, y))


def _runs(start: Ints, count: Ints) -> Ints:
    """`count` whole numbers up from each `start`, one run after the other."""
    before = np.cumsum(count) - count
    return np.asarray(np.arange(int(count.sum())) + np.repeat(start - before, count), np.int64)


def _spans(lens: Lens, px: Pixels, faces: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Cut each triangle into rows of pixels: its number, the row, the first and the last column."""
    y = px[:, 1].take(faces)
    low = np.maximum(np.ceil(y.min(axis=1)), 0.0).astype(np.int64)
    count = np.minimum(np.floor(y.max(axis=1)), lens.height - 1.0).astype(np.int64) - low + 1
    count = np.maximum(count, 0)
    face = np.repeat(np.arange(len(faces)), count)
    row = _runs(low, count)
    left = np.zeros(len(face), np.float32)
    right = np.full(len(face), lens.width - 1.0, np.float32)
    for k in range(3):  # each edge bounds the row on one side
        a, b = px.take(faces[:, k], axis=0), px.take(faces[:, (k + 1) % 3], axis=0)
        rise = b[:, 1] - a[:, 1]
        slope = (b[:, 0] - a[:, 0]) / np.where(rise == 0.0, np.float32(1.0), rise)
        cut = (a[:, 0] - slope * a[:, 1]).take(face) + slope.take(face) * row.astype(np.float32)
        side = rise.take(face)
        left = np.where(side > 0.0, np.maximum(left, cut), left)
        right = np.where(side < 0.0, np.minimum(right, cut), right)
    first = np.ceil(np.minimum(left, lens.width)).astype(np.int64)
    last = np.floor(np.maximum(right, -1.0)).astype(np.int64)
    kept = np.flatnonzero(first <= last)
    return face.take(kept), row.take(kept), first.take(kept), last.take(kept)


def _shares(px: Pixels, corners: Ints, x: Ints, y: Ints) -> Pixels:
    """(N, 3) barycentric shares of pixel centres in their triangles."""
    a, b, c = (px.take(corners[:, k], axis=0) for k in range(3))
    ab, ac = b - a, c - a
    dx, dy = x.astype(np.float32) - a[:, 0], y.astype(np.float32) - a[:, 1]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    share_b = (dx * ac[:, 1] - dy * ac[:, 0]) / area
    share_c = (ab[:, 0] * dy - ab[:, 1] * dx) / area
    return np.column_stack([1.0 - share_b - share_c, share_b, share_c])


def _towards(px: Pixels, z: Pixels, faces: Ints) -> Ints:
    """The faces that turn to the camera and lie in front of it, from far to near."""
    a, b, c = (px.take(faces[:, k], axis=0) for k in range(3))
    # Twice the signed area: what turns its back to the camera has the other sign (y is down).
    area: Pixels = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (
        c[:, 0] - a[:, 0]
    )
    depth = z.take(faces)
    kept = np.flatnonzero((area < -1e-6) & (depth.min(axis=1) > NEAR_MM))
    far_first = np.argsort(-depth.take(kept, axis=0).sum(axis=1), kind="stable")
    return faces.take(kept.take(far_first), axis=0)
