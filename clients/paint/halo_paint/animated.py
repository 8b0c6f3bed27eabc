"""A recorded stream as a picture that paints itself.

Rule: pure text. Each stroke is that of the saved SVG behind a mask that uncovers it, along the way
of the finger and in its time. Strokes that were undone do not appear.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from halo_paint.brushes import PAPER
from halo_paint.painter import Painter
from halo_paint.stroke import Stroke, whole
from halo_paint.svg import stroke_lines
from halo_protocol import TouchFrame
from halo_window.animated import Animation, rgb

FINGER = "#6e4080"
POINT_MM = 2.0
"""Distance between points of the way."""


def to_svg(
    frames: Sequence[TouchFrame], painter: Painter, width_mm: float, height_mm: float
) -> str:
    """Return the text of a file."""
    grown: dict[int, list[tuple[int, int]]] = {}
    seen: list[Stroke] = []  # so that no id is used twice
    for frame in frames:
        for _, stroke in painter.process(frame):
            if stroke is not None:
                seen.append(stroke)
                grown.setdefault(id(stroke), []).append((frame.time_us, len(stroke.pieces)))
    animation = Animation.of(frames, width_mm, height_mm)
    for number, stroke in enumerate(painter.strokes):
        if stroke.pieces:
            animation.lines += _stroke(animation, stroke, number, grown[id(stroke)])
    animation.fingers(frames, FINGER)
    return animation.text(rgb(PAPER))


def _stroke(
    animation: Animation, stroke: Stroke, number: int, grown: Sequence[tuple[int, int]]
) -> list[str]:
    piece = whole(stroke)
    steps = np.hypot(np.diff(piece.x), np.diff(piece.y))
    along = np.concatenate([[0.0], np.cumsum(steps)])
    counts = np.cumsum([len(each.x) - 1 for each in stroke.pieces])
    length, width = float(along[-1]), 2.0 * float(piece.radius.max()) + 2.0
    # A dash that is longer than the way moves in. Its round ends need room beyond both ends.
    dash = length + 3.0 * width
    way = [(at, dash - float(along[counts[pieces - 1]])) for at, pieces in grown if pieces]
    way = [(way[0][0] - 1000, dash + width), *way]
    chosen = np.unique(np.searchsorted(along, np.arange(0.0, length, POINT_MM)))
    points = " ".join(f"{piece.x[n]:.1f},{piece.y[n]:.1f}" for n in (*chosen, len(along) - 1))
    return [
        f'<mask id="way{number}" maskUnits="userSpaceOnUse" x="0" y="0" '
        f'width="{animation.width_mm:g}" height="{animation.height_mm:g}">',
        f'<polyline points="{points}" fill="none" stroke="#ffffff" stroke-width="{width:.1f}" '
        f'stroke-linecap="round" stroke-linejoin="round" stroke-dasharray="{dash:.1f}">',
        animation.moving("stroke-dashoffset", way),
        "</polyline></mask>",
        f'<g mask="url(#way{number})">',
        *stroke_lines(stroke, number),
        "</g>",
    ]
