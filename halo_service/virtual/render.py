"""Triangles to pixels: which point of which mesh a camera sees in each pixel.

Rule: geometry only; what the pixel then measures is the sensor's business. Exact at pixel
centres, through the lens's distortion (an edge between two projected vertices is straight, which
at a few millimetres a triangle is off by less than a hundredth of a pixel). Where faces of a mesh
hide each other, the pixel shows the nearest.
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
class _Spans:
    """Faces, cut into rows of pixels."""

    corners: Ints
    """(3, F) vertices."""
    x: Pixels
    """(3, F) columns of these, px."""
    y: Pixels
    """(3, F) rows of these, px."""
    face: Ints
    """(S,) which face."""
    row: Ints
    """(S,)."""
    first: Ints
    """(S,) the leftmost column."""
    count: Ints
    """(S,) how many columns."""

    def evenly(self, per_vertex: Pixels) -> tuple[Pixels, Pixels]:
        """(K, S) values at the spans' first pixels, and their change by column; from (K, V)."""
        (xa, xb, xc), (ya, yb, yc) = self.x, self.y
        ab_x, ab_y, ac_x, ac_y = xb - xa, yb - ya, xc - xa, yc - ya
        area = ab_x * ac_y - ab_y * ac_x
        a, b, c = (per_vertex.take(corner, axis=1) for corner in self.corners)
        b, c = (b - a) / area, (c - a) / area
        by_column, by_row = b * ac_y - c * ab_y, c * ab_x - b * ac_x
        right = self.first.astype(np.float32) - xa.take(self.face)
        down = self.row.astype(np.float32) - ya.take(self.face)
        slope: Pixels = by_column.take(self.face, axis=1)
        start = a.take(self.face, axis=1) + slope * right + by_row.take(self.face, axis=1) * down
        return start, slope


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What of a mesh is seen, pixel by pixel.

    A quantity changes evenly over a face. So its value at the first pixel of a span and its change
    by column give it at each pixel.
    """

    pixel: Ints
    """(N,) flat pixel numbers, row * width + column, each once."""
    depth: Pixels
    """(N,) mm along the lens's axis."""
    _span: Ints
    """(N,) the span of each pixel."""
    _step: Pixels
    """(N,) columns from the span's first."""
    _spans: _Spans

    @property
    def corner(self) -> Ints:
        """(N,) one vertex of the triangle that is seen there."""
        corner: Ints = self._spans.corners[0].take(self._spans.face).take(self._span)
        return corner

    def only(self, which: Ints) -> Seen:
        """Some of the pixels: (M,) numbers below N, ascending."""
        if len(which) == len(self.pixel):
            return self
        span, step = self._span.take(which), self._step.take(which)
        return Seen(self.pixel.take(which), self.depth.take(which), span, step, self._spans)

    def mix(self, per_vertex: Pixels) -> Pixels:
        """(K, N) from (K, V): K vertex quantities at each pixel."""
        return _mixed(self._spans, self._span, self._step, per_vertex)


def rasterise(lens: Lens, points: Floats, faces: Ints) -> Seen:
    """See a closed mesh, (V, 3) in the camera's frame, through a lens; the nearest face wins."""
    x, y, z = _project(lens, points)
    spans = _cut(lens, x, y, _towards(x, y, z, faces.T))
    span = np.repeat(np.arange(len(spans.face)), spans.count)
    before = np.cumsum(spans.count) - spans.count
    pixel = np.arange(len(span))
    step = (pixel - before.take(span)).astype(np.float32)
    pixel += (spans.row * lens.width + spans.first - before).take(span)
    depth = _mixed(spans, span, step, z[None])[0]
    drawn = Seen(pixel, depth, span, step, spans)
    return drawn.only(_nearest(pixel, depth, lens.width * lens.height))


def _mixed(spans: _Spans, span: Ints, step: Pixels, per_vertex: Pixels) -> Pixels:
    """(K, N) from (K, V), at (N,) columns from the first of (N,) spans."""
    start, slope = spans.evenly(per_vertex)
    # Looked up together, in numbers of twice the size.
    both = np.empty(start.shape, np.complex64)
    both.real, both.imag = start, slope
    mixed: Pixels = np.empty((len(start), len(span)), np.float32)
    for each, out in zip(both, mixed, strict=True):
        found = each.take(span)
        np.multiply(found.imag, step, out=out)
        out += found.real
    return mixed


def _nearest(pixel: Ints, depth: Pixels, pixels: int) -> Ints:
    """(M,) numbers of those that are the nearest in their pixel, ascending."""
    number = np.arange(len(pixel))
    winner: Ints = np.empty(pixels, np.int64)  # read only where it is written to
    winner[pixel] = number
    hidden = np.flatnonzero(winner.take(pixel) != number)
    if len(hidden) == 0:
        return number
    rivals = np.concatenate([winner.take(pixel.take(hidden)), hidden])
    far_first = rivals.take(np.argsort(-depth.take(rivals)))
    winner[pixel.take(far_first)] = far_first
    return np.flatnonzero(winner.take(pixel) == number)


def _project(lens: Lens, points: Floats) -> tuple[Pixels, Pixels, Pixels]:
    """Columns and rows, px, and depths, mm; depth 0 for what the lens does not see."""
    x, y, z = points.T
    seen = (z > 0.0) & (x * x + y * y < (WIDEST * z) ** 2)
    # Elsewhere (an upper arm as high as the lens) the model divides by about zero.
    x, y, away = np.where(seen, x, 0.0), np.where(seen, y, 0.0), 1.0 / np.where(seen, z, 1.0)
    column, row = lens.distorted(x * away, y * away)
    return (
        column.astype(np.float32),
        row.astype(np.float32),
        np.where(seen, z, 0.0).astype(np.float32),
    )


def _towards(x: Pixels, y: Pixels, z: Pixels, corners: Ints) -> Ints:
    """The faces that turn to the camera and lie in front of it: (3, F)."""
    place = np.empty(len(x), np.complex64)  # both at once: looking them up costs most
    place.real, place.imag = x, y
    a, b, c = (place.take(corner) for corner in corners)
    b -= a
    c -= a
    # Twice the signed area: what turns its back to the camera has the other sign (y is down).
    area = b.real * c.imag - b.imag * c.real
    towards = corners.take(np.flatnonzero(area < -1e-6), axis=1)
    nearest = np.minimum.reduce(z.take(towards), axis=0)
    return towards.take(np.flatnonzero(nearest > NEAR_MM), axis=1)


def _cut(lens: Lens, x: Pixels, y: Pixels, corners: Ints) -> _Spans:
    """Cut each triangle into rows of pixels."""
    xs, ys = x.take(corners), y.take(corners)
    (xt, xm, xb), (yt, ym, yb) = _from_top(xs, ys)
    low = np.maximum(np.ceil(yt), np.float32(0.0))
    rows = np.minimum(np.floor(yb), np.float32(lens.height - 1)) - low + np.float32(1.0)
    count = np.maximum(rows, np.float32(0.0)).astype(np.int64)
    face = np.repeat(np.arange(len(count)), count)
    down = np.arange(len(face)) - (np.cumsum(count) - count).take(face)
    # A row reaches from the long edge, top to bottom, to that of the other two which it meets.
    edges = np.concatenate(
        [_edge(xt, yt, xm, ym, low), _edge(xb, yb, xm, ym, low), _edge(xt, yt, xb, yb, low)]
    )
    deep = down.astype(np.float32)
    lower = deep >= (ym - low).take(face)
    one, other = (
        edge.real + edge.imag * deep
        for edge in (edges[2 * len(count) :].take(face), edges.take(face + len(count) * lower))
    )
    first = np.ceil(np.maximum(np.minimum(one, other), np.float32(0.0)))
    last = np.floor(np.minimum(np.maximum(one, other), np.float32(lens.width - 1)))
    visible = np.flatnonzero(last >= first)
    first = first.take(visible)
    wide = (last.take(visible) - first).astype(np.int64) + 1
    face = face.take(visible)
    row = low.astype(np.int64).take(face) + down.take(visible)
    return _Spans(corners, xs, ys, face, row, first.astype(np.int64), wide)


def _from_top(xs: Pixels, ys: Pixels) -> tuple[list[Pixels], list[Pixels]]:
    """The corners of each triangle from the highest to the lowest: three columns, three rows."""
    x, y = list(xs), list(ys)
    for i, j in ((0, 1), (1, 2), (0, 1)):
        turned = y[i] > y[j]
        x[i], x[j] = np.where(turned, x[j], x[i]), np.where(turned, x[i], x[j])
        y[i], y[j] = np.minimum(y[i], y[j]), np.maximum(y[i], y[j])
    return x, y


def _edge(x: Pixels, y: Pixels, to_x: Pixels, to_y: Pixels, row: Pixels) -> NDArray[np.complex64]:
    """An edge's column at a row, and as the imaginary part its change from row to row."""
    edge = np.empty(len(x), np.complex64)  # for they are looked up together
    rise = to_y - y
    edge.imag = (to_x - x) / np.where(rise == 0.0, np.float32(1.0), rise)
    edge.real = x + (row - y) * edge.imag
    return edge
