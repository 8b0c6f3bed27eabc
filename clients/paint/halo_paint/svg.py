"""Strokes as an SVG: curves in millimetres, to be scaled to any size.

Rule: pure; returns text. A stroke is a rectangle of its colour behind a mask; the mask's grey
is the ink. Greys are opaque, so overlapping parts of a stroke do not add up, as on the canvas.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from halo_paint.brushes import PAPER, Array, Colour
from halo_paint.stroke import Piece, Stroke, whole

SPACING_MM = 1.4
"""Distance between points in the file; cubic curves join them."""
GREYS = 32
"""Number of ink levels along a strand."""
OVERLAP = 0.3
"""Overlap of neighbouring strands, relative to their width: no gaps."""
TURN = 0.5
"""Change of direction between two points, radians, above which a disc rounds the outer edge."""
TAPER = 0.5
"""Change of the radius over the way, above which a disc rounds the wider end."""


def to_svg(
    strokes: Iterable[Stroke], width_mm: float, height_mm: float, paper: Colour = PAPER
) -> str:
    """Return the text of a file."""
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width_mm:g}mm" height="{height_mm:g}mm" '
        f'viewBox="0 0 {width_mm:g} {height_mm:g}">',
        f'<rect width="100%" height="100%" fill="{_hex(paper)}"/>',
    ]
    for number, stroke in enumerate(strokes):
        if stroke.pieces:
            lines += stroke_lines(stroke, number)
    return "\n".join([*lines, "</svg>", ""])


def stroke_lines(stroke: Stroke, number: int) -> Iterator[str]:
    """Return the lines of one stroke; its number names its mask."""
    piece = _visible(_thinned(whole(stroke)))
    reach = float(piece.radius.max()) + 1.0
    left, top = float(piece.x.min()) - reach, float(piece.y.min()) - reach
    right, low = float(piece.x.max()) + reach, float(piece.y.max()) + reach
    area = f'x="{left:.2f}" y="{top:.2f}" width="{right - left:.2f}" height="{low - top:.2f}"'
    yield f'<mask id="stroke{number}" maskUnits="userSpaceOnUse" {area}>'
    count = piece.ink.shape[1]
    yield from _discs(piece)
    for strand in range(count):
        yield from _strand(piece, strand, count)
    yield "</mask>"
    yield f'<rect {area} fill="{_hex(stroke.colour)}" mask="url(#stroke{number})"/>'


def _thinned(piece: Piece) -> Piece:
    """Fewer points, the first and the last among them."""
    steps = np.hypot(np.diff(piece.x), np.diff(piece.y))
    along = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(2, 1 + round(float(along[-1]) / SPACING_MM))
    chosen = np.searchsorted(along, np.linspace(0.0, along[-1], count))
    keep = np.unique(np.concatenate([[0], chosen, [len(along) - 1]]).clip(0, len(along) - 1))
    return _select(piece, keep)


def _visible(piece: Piece) -> Piece:
    """Remove points inside a larger disc, as when a finger lifts off where it pressed."""
    apart = np.hypot(piece.x[:, None] - piece.x, piece.y[:, None] - piece.y)
    hidden = (apart + piece.radius[:, None] < piece.radius).any(axis=1)
    return _select(piece, np.flatnonzero(~hidden))


def _select(piece: Piece, keep: NDArray[np.intp]) -> Piece:
    return Piece(
        piece.x[keep], piece.y[keep], piece.radius[keep], piece.direction[keep], piece.ink[keep]
    )


def _strand(piece: Piece, strand: int, count: int) -> Iterator[str]:
    """One strand: runs of constant ink, each a closed curve."""
    low, high = (2 * (strand + n) / count - 1 for n in (0, 1))
    if strand < count - 1:
        high += OVERLAP * 2 / count
    edges = [_edge(piece, side, capped=count > 1) for side in (low, high)]
    greys = np.round(piece.ink[:, strand] * GREYS).astype(int)
    if count > 1:
        greys = np.concatenate([greys[:1], greys, greys[-1:]])
    for begin, end in _runs(greys):
        shade = _grey(int(greys[begin]))
        # Two points more than the run: the next run covers them, so that no seam is visible.
        path = _closed(*(edge[begin : end + 3] for edge in edges))
        if path:
            yield f'<path fill="{shade}" d="{path}"/>'


def _discs(piece: Piece) -> Iterator[str]:
    """Round ends, and round corners where the stroke turns or narrows sharply."""
    last = len(piece.x) - 1
    turns = np.abs(np.angle(np.exp(1j * np.diff(piece.direction))))
    steps = np.hypot(np.diff(piece.x), np.diff(piece.y))
    sharp = np.flatnonzero((turns > TURN) | (np.abs(np.diff(piece.radius)) > TAPER * steps))
    for n in sorted({0, last, *sharp.tolist(), *(sharp + 1).tolist()}):
        shade = _grey(round(GREYS * float(np.median(piece.ink[n]))))
        yield (
            f'<circle cx="{piece.x[n]:.2f}" cy="{piece.y[n]:.2f}" '
            f'r="{piece.radius[n]:.2f}" fill="{shade}"/>'
        )


def _edge(piece: Piece, side: float, *, capped: bool) -> Array:
    """(N, 2) points at -1, the left edge, to 1, the right one; with a round end if `capped`."""
    cos, sin = np.cos(piece.direction), np.sin(piece.direction)
    away = piece.radius * side
    points: Array = np.stack([piece.x - sin * away, piece.y + cos * away], axis=1)
    if not capped:
        return points
    ahead = np.stack([cos, sin], axis=1) * (piece.radius * np.sqrt(max(0.0, 1 - side**2)))[:, None]
    ended: Array = np.concatenate([points[:1] - ahead[:1], points, points[-1:] + ahead[-1:]])
    return ended


def _runs(greys: NDArray[np.int_]) -> list[tuple[int, int]]:
    """First and last index of each run of the same grey."""
    breaks = np.flatnonzero(np.diff(greys)) + 1
    begins, ends = [0, *breaks.tolist()], [*(breaks - 1).tolist(), len(greys) - 1]
    return list(zip(begins, ends, strict=True))


def _closed(left: Array, right: Array) -> str:
    """Along the left edge, then back along the right edge."""
    if len(left) < 2:
        return ""
    there, back = _curve(left), _curve(right[::-1])
    begin, turn = _point(left[0]), _point(right[-1])
    return f"M{begin}{there}L{turn}{back}Z"


def _curve(points: Array) -> str:
    """Cubic curves through points (Catmull-Rom), from the current point."""
    padded = np.concatenate([points[:1], points, points[-1:]])
    handles = (padded[2:] - padded[:-2]) / 6
    parts = [
        f"C{_point(a + out)} {_point(b - come)} {_point(b)}"
        for a, b, out, come in zip(points, points[1:], handles, handles[1:], strict=False)
    ]
    return "".join(parts)


def _point(point: Array) -> str:
    return f"{point[0]:.2f},{point[1]:.2f}"


def _grey(step: int) -> str:
    return _hex((round(255 * step / GREYS),) * 3)


def _hex(colour: tuple[int, ...]) -> str:
    return "#" + "".join(f"{part:02x}" for part in colour)
