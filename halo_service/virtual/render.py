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
    """(3, N) the vertices of the triangle seen there."""
    share: Pixels
    """(3, N) barycentric shares of these."""

    def mix(self, per_vertex: Pixels) -> Pixels:
        """(K, N) from (K, V): K vertex quantities at each pixel."""
        a, b, c = (per_vertex.take(self.corners[k], axis=1) * self.share[k] for k in range(3))
        return np.asarray(a + b + c, dtype=np.float32)


_NOTHING = Seen(np.empty(0, np.int64), np.empty((3, 0), np.int64), np.empty((3, 0), np.float32))


def rasterise(lens: Lens, points: Floats, faces: Ints) -> Seen:
    """See a closed mesh, (V, 3) in the camera's frame, through a lens; the nearest face wins."""
    x, y, z = _project(lens, points)
    corners = _towards(x, y, z, np.ascontiguousarray(faces.T))
    xs, ys = x.take(corners), y.take(corners)
    face, row, first, last = _spans(lens, xs, ys)
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
    face, row = face.take(span), row.take(span)
    share = _shares(xs, ys, face, pixel - row * lens.width, row)
    return Seen(pixel, corners.take(face, axis=1), share)


def _project(lens: Lens, points: Floats) -> tuple[Pixels, Pixels, Pixels]:
    """Columns and rows, px, and depths, mm; depth 0 for what the lens does not see.

    The same numbers as `Lens.project`, which calls OpenCV: its function spends most of its time
    on derivatives.
    """
    x, y, z = points.T
    seen = (z > 0.0) & (x * x + y * y < (WIDEST * z) ** 2)
    # Elsewhere (an upper arm as high as the lens) the model divides by about zero.
    x, y, away = np.where(seen, x, 0.0), np.where(seen, y, 0.0), 1.0 / np.where(seen, z, 1.0)
    x, y = x * away, y * away
    k1, k2, p1, p2, k3, k4, k5, k6 = lens.distortion
    r2 = x * x + y * y
    r4 = r2 * r2
    r6 = r4 * r2
    radial = 1.0 + k1 * r2 + k2 * r4 + k3 * r6
    less = 1.0 / (1.0 + k4 * r2 + k5 * r4 + k6 * r6)
    twice = 2.0 * x * y
    column = x * radial * less + p1 * twice + p2 * (r2 + 2.0 * x * x)
    row = y * radial * less + p1 * (r2 + 2.0 * y * y) + p2 * twice
    return (
        (column * lens.fx + lens.cx).astype(np.float32),
        (row * lens.fy + lens.cy).astype(np.float32),
        np.where(seen, z, 0.0).astype(np.float32),
    )


def _towards(x: Pixels, y: Pixels, z: Pixels, corners: Ints) -> Ints:
    """The faces that turn to the camera and lie in front of it, from far to near; (3, F)."""
    (xa, xb, xc), (ya, yb, yc), (za, zb, zc) = (at.take(corners) for at in (x, y, z))
    # Twice the signed area: what turns its back to the camera has the other sign (y is down).
    area: Pixels = (xb - xa) * (yc - ya) - (yb - ya) * (xc - xa)
    nearest = np.minimum(np.minimum(za, zb), zc)
    visible = np.flatnonzero((area < -1e-6) & (nearest > NEAR_MM))
    depth = (za + (zb + zc)).take(visible)
    # Bits of positive floats have their order. With the face's number below them, a plain sort
    # keeps the order of equal ones, and is several times faster than a stable one.
    keys = (-depth.view(np.int32)).astype(np.int64) << 32 | visible
    keys.sort()
    far_first: Ints = keys & 0xFFFFFFFF
    return corners.take(far_first, axis=1)


def _runs(start: Ints, count: Ints) -> Ints:
    """`count` whole numbers up from each `start`, one run after the other."""
    before = np.cumsum(count) - count
    return np.asarray(np.arange(int(count.sum())) + np.repeat(start - before, count), np.int64)


def _spans(lens: Lens, xs: Pixels, ys: Pixels) -> tuple[Ints, Ints, Ints, Ints]:
    """Cut each triangle into rows of pixels: its number, the row, the first and the last column."""
    top, bottom = np.minimum.reduce(ys, axis=0), np.maximum.reduce(ys, axis=0)
    low = np.maximum(np.ceil(top), 0.0).astype(np.int64)
    count = np.minimum(np.floor(bottom), lens.height - 1.0).astype(np.int64) - low + 1
    count = np.maximum(count, 0)
    face = np.repeat(np.arange(len(count)), count)
    row = _runs(low, count)
    height = row.astype(np.float32)
    left = np.zeros(len(face), np.float32)
    right = np.full(len(face), lens.width - 1.0, np.float32)
    for a, b in ((0, 1), (1, 2), (2, 0)):  # each edge bounds the row on one side
        rise = ys[b] - ys[a]
        slope = (xs[b] - xs[a]) / np.where(rise == 0.0, np.float32(1.0), rise)
        start = xs[a] - slope * ys[a]
        along = slope.take(face) * height
        after, before = np.where(rise > 0.0, start, -np.inf), np.where(rise < 0.0, start, np.inf)
        np.maximum(left, after.take(face) + along, out=left)
        np.minimum(right, before.take(face) + along, out=right)
    first = np.ceil(np.minimum(left, lens.width)).astype(np.int64)
    last = np.floor(np.maximum(right, -1.0)).astype(np.int64)
    visible = np.flatnonzero(first <= last)
    return face.take(visible), row.take(visible), first.take(visible), last.take(visible)


def _shares(xs: Pixels, ys: Pixels, face: Ints, column: Ints, row: Ints) -> Pixels:
    """(3, N) barycentric shares of pixel centres in their triangles."""
    xa, xb, xc = xs
    ya, yb, yc = ys
    ab_x, ab_y, ac_x, ac_y = xb - xa, yb - ya, xc - xa, yc - ya
    area = (ab_x * ac_y - ab_y * ac_x).take(face)
    dx, dy = column.astype(np.float32) - xa.take(face), row.astype(np.float32) - ya.take(face)
    share_b = (dx * ac_y.take(face) - dy * ac_x.take(face)) / area
    share_c = (ab_x.take(face) * dy - ab_y.take(face) * dx) / area
    return np.stack([1.0 - share_b - share_c, share_b, share_c])
