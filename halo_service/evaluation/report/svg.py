"""Marks on a panel: numbers in, SVG text out.

Rule: other modules decide what is drawn. Colours and fonts are the page's: marks carry classes,
so that one style sheet serves light and dark. Coordinates are rounded to tenths of a pixel: the
same numbers give the same bytes, and thousands of dots stay a small page.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from halo_service.evaluation.metrics.spatial import Ellipse

Values = Iterable[float]

LEFT, RIGHT, TOP, BOTTOM = 46.0, 12.0, 26.0, 40.0
"""Margins around a panel, px: room for its title, its numbers and its labels."""
TICK, NEAR = 4.0, 13.0
"""Length of a tick, and the distance of its number from the panel, px."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A rectangle with two scales."""

    width: float
    height: float
    """Of the rectangle without its margins, px."""
    x: tuple[float, float]
    """Values at the left and at the right."""
    y: tuple[float, float]
    """Values at the bottom and at the top."""

    def px(self, value: float) -> float:
        """Where a value lies from the drawing's left, px."""
        low, high = self.x
        return LEFT + self.width * (value - low) / (high - low)

    def py(self, value: float) -> float:
        """Where a value lies from the drawing's top, px."""
        low, high = self.y
        return TOP + self.height * (high - value) / (high - low)


def drawing(panel: Panel, words: str, marks: Iterable[str]) -> str:
    """Wrap marks into an image; `words` describe it for screen readers."""
    width, height = panel.width + LEFT + RIGHT, panel.height + TOP + BOTTOM
    return (
        f'<svg viewBox="0 0 {_n(width)} {_n(height)}" width="{_n(width)}" role="img" '
        f'aria-label="{escape(words)}">{"".join(marks)}</svg>'
    )


def axes(
    panel: Panel,
    title: str,
    x_label: str,
    y_label: str,
    x_ticks: Sequence[tuple[float, str]],
    y_ticks: Sequence[tuple[float, str]],
) -> str:
    """Draw the frame, its numbers and its words."""
    left, right = panel.px(panel.x[0]), panel.px(panel.x[1])
    bottom, top = panel.py(panel.y[0]), panel.py(panel.y[1])
    parts = [
        f'<rect class="panel" x="{_n(left)}" y="{_n(top)}" width="{_n(right - left)}" '
        f'height="{_n(bottom - top)}"/>',
        text(left, top - 9.0, title, "title"),
        text((left + right) / 2.0, bottom + 32.0, x_label, "label middle"),
        f'<g transform="translate(11 {_n((top + bottom) / 2.0)}) rotate(-90)">'
        f"{text(0.0, 0.0, y_label, 'label middle')}</g>",
    ]
    for value, words in x_ticks:
        x = panel.px(value)
        parts.append(_segment(x, bottom, x, bottom + TICK, "tick"))
        parts.append(text(x, bottom + TICK + NEAR, words, "number middle"))
    for value, words in y_ticks:
        y = panel.py(value)
        parts.append(_segment(left, y, right, y, "grid"))
        parts.append(text(left - 6.0, y + 3.5, words, "number end"))
    return "".join(parts)


def ticks(*values: float) -> list[tuple[float, str]]:
    """Return numbers with their own text."""
    return [(value, f"{value:g}") for value in values]


def dots(panel: Panel, xs: Values, ys: Values, kind: str) -> str:
    """Draw dots as one short path, without those outside the panel."""
    places = zip(xs, ys, strict=True)
    inside = [(x, y) for x, y in places if _within(x, panel.x) and _within(y, panel.y)]
    steps = "".join(f"M{_n(panel.px(x))} {_n(panel.py(y))}h0" for x, y in inside)
    return f'<path class="dots {kind}" d="{steps}"/>' if steps else ""


def line(panel: Panel, xs: Values, ys: Values, kind: str) -> str:
    """Draw a line through points, clamped to the panel."""
    points = _points(panel, xs, ys)
    return f'<polyline class="line {kind}" points="{points}"/>' if points else ""


def bar(panel: Panel, from_x: float, to_x: float, y: float, kind: str) -> str:
    """Draw a bar from the panel's bottom up."""
    left, right, top = panel.px(from_x), panel.px(to_x), panel.py(min(y, max(panel.y)))
    height = panel.py(panel.y[0]) - top
    return (
        f'<rect class="bar {kind}" x="{_n(left)}" y="{_n(top)}" width="{_n(right - left)}" '
        f'height="{_n(height)}"/>'
    )


def oval(panel: Panel, ellipse: Ellipse, kind: str) -> str:
    """Draw an ellipse given in the panel's units, clamped to the panel."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    along = np.radians(ellipse.angle_deg)
    a, b = ellipse.major_mm * np.cos(turn), ellipse.minor_mm * np.sin(turn)
    xs = ellipse.x_mm + a * np.cos(along) - b * np.sin(along)
    ys = ellipse.y_mm + a * np.sin(along) + b * np.cos(along)
    points = _points(panel, xs.tolist(), ys.tolist())
    return f'<polygon class="oval {kind}" points="{points}"/>'


def cross(panel: Panel, x: float, y: float, size: float = 4.0) -> str:
    """Mark a place."""
    cx, cy = panel.px(x), panel.py(y)
    return _segment(cx - size, cy, cx + size, cy, "cross") + _segment(
        cx, cy - size, cx, cy + size, "cross"
    )


def upright(panel: Panel, x: float, words: str) -> str:
    """Draw a dashed line at a value, with a word next to it."""
    at = panel.px(x)
    top, bottom = panel.py(panel.y[1]), panel.py(panel.y[0])
    return _segment(at, top, at, bottom, "mark") + text(at + 4.0, top + 11.0, words, "number")


def coloured(method: str) -> str:
    """Return the class that gives a mark its method's colour."""
    return f"m-{method}"


def text(x: float, y: float, words: str, kind: str) -> str:
    """Write words at a place in px."""
    return f'<text class="{kind}" x="{_n(x)}" y="{_n(y)}">{escape(words)}</text>' if words else ""


def _segment(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    return f'<path class="{kind}" d="M{_n(x1)} {_n(y1)}L{_n(x2)} {_n(y2)}"/>'


def _points(panel: Panel, xs: Values, ys: Values) -> str:
    return " ".join(
        f"{_n(panel.px(_clamped(x, panel.x)))},{_n(panel.py(_clamped(y, panel.y)))}"
        for x, y in zip(xs, ys, strict=True)
    )


def _clamped(value: float, ends: tuple[float, float]) -> float:
    return min(max(value, min(ends)), max(ends))


def _within(value: float, ends: tuple[float, float]) -> bool:
    return min(ends) <= value <= max(ends)


def _n(value: float) -> str:
    """A coordinate, to tenths of a pixel."""
    return f"{round(value, 1) + 0.0:g}"  # adding 0 makes a zero of what would print as -0
