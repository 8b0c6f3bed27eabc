"""A recorded stream as an SVG that moves: a picture for a web page, which repeats.

Rule: pure text, no pygame. Lengths are millimetres on the surface; times are those of the frames.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from halo_protocol import Pointer, TouchFrame

BEFORE_S, AFTER_S = 1.0, 1.5
"""What is shown before the first touch and after the last one."""
NEAR_MM = 60.0
"""Fingers that are higher are not shown."""
FINGER_MM = 3.0
WIDTH_PX = 720
EACH_US = 60_000
"""Shortest time between two places of a finger: the file stays small, and looks as smooth."""

EARLIEST_US = -(2**63)

Point = tuple[int, float]
"""A time in us, and a value."""


@dataclass(slots=True)
class Animation:
    """Lines of an SVG, and the time that it shows."""

    width_mm: float
    height_mm: float
    begin_us: int
    end_us: int
    lines: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, frames: Sequence[TouchFrame], width_mm: float, height_mm: float) -> Animation:
        """From before the first touch until after the last one; all frames if nothing touches."""
        times = [frame.time_us for frame in frames if frame.downs or _touching(frame)]
        times = times or [frame.time_us for frame in frames] or [0]
        begin_us, end_us = times[0] - round(BEFORE_S * 1e6), times[-1] + round(AFTER_S * 1e6)
        return cls(width_mm, height_mm, begin_us, end_us)

    def moving(self, attribute: str, points: Iterable[Point]) -> str:
        """Return an element that moves an attribute from point to point."""
        return self._animate(attribute, self._within(points), "")

    def stepping(self, attribute: str, points: Iterable[Point], first: float = 0.0) -> str:
        """Return an element that sets an attribute at each point; `first` before all points."""
        return self._animate(
            attribute, self._within([(EARLIEST_US, first), *points]), ' calcMode="discrete"'
        )

    def shown(self, begin_us: int, end_us: int | None = None) -> str:
        """Return an element that makes something visible from a time on, until another."""
        end = [] if end_us is None else [(end_us, 0.0)]
        return self.stepping("opacity", [(begin_us, 1.0), *end])

    def fingers(self, frames: Sequence[TouchFrame], colour: str) -> None:
        """Draw each finger as a ring that shrinks while it comes down, filled while it touches."""
        tracks: dict[int, list[tuple[int, Pointer | None]]] = {}
        for frame in frames:
            near = {p.id: p for p in frame.pointers if p.touching or p.hover_mm < NEAR_MM}
            for id_ in near.keys() | tracks.keys():
                tracks.setdefault(id_, []).append((frame.time_us, near.get(id_)))
        for track in tracks.values():
            there = thinned([(at, each) for at, each in track if each is not None])
            self.lines.append(
                f'<circle fill="{colour}" stroke="{colour}" stroke-width="0.6">'
                + self.moving("cx", [(at, each.x_mm) for at, each in there])
                + self.moving("cy", [(at, each.y_mm) for at, each in there])
                + self.moving("r", [(at, _radius(each)) for at, each in there])
                + self.stepping("fill-opacity", changes((at, _fill(each)) for at, each in track))
                + self.stepping(
                    "stroke-opacity", changes((at, 0.0 if p is None else 0.9) for at, p in track)
                )
                + "</circle>"
            )

    def text(self, background: str) -> str:
        """Return the text of the file."""
        size = f"{self.width_mm:g} {self.height_mm:g}"
        height_px = round(WIDTH_PX * self.height_mm / self.width_mm)
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH_PX}" height="{height_px}" '
            f'viewBox="0 0 {size}" font-family="sans-serif">'
        )
        paper = f'<rect width="100%" height="100%" fill="{background}"/>'
        return "\n".join([head, paper, *self.lines, "</svg>", ""])

    @property
    def _seconds(self) -> float:
        return max(self.end_us - self.begin_us, 1) / 1e6

    def _within(self, points: Iterable[Point]) -> list[Point]:
        """The points in time, the last one before the beginning moved to it."""
        ordered = sorted(points, key=lambda point: point[0])
        inside = [point for point in ordered if self.begin_us < point[0] < self.end_us]
        before = [point for point in ordered if point[0] <= self.begin_us]
        first = before[-1] if before else ordered[0]
        return [(self.begin_us, first[1]), *inside]

    def _animate(self, attribute: str, points: list[Point], mode: str) -> str:
        span = max(self.end_us - self.begin_us, 1)
        if not mode:
            points = [*points, (self.end_us, points[-1][1])]
        times = ";".join(_number((at - self.begin_us) / span, 4) for at, _ in points)
        values = ";".join(_number(value, 2) for _, value in points)
        return (
            f'<animate attributeName="{attribute}" dur="{self._seconds:.2f}s" '
            f'repeatCount="indefinite"{mode} keyTimes="{times}" values="{values}"/>'
        )


def changes(points: Iterable[Point]) -> list[Point]:
    """Only the points at which the value differs from the one before."""
    chosen: list[Point] = []
    for at, value in points:
        if not chosen or chosen[-1][1] != value:
            chosen.append((at, value))
    return chosen


def thinned(track: list[tuple[int, Pointer]]) -> list[tuple[int, Pointer]]:
    """Fewer places of a finger; the beginning and the end of a touch stay."""
    chosen = track[:1]
    for at, pointer in track[1:]:
        if at - chosen[-1][0] >= EACH_US or pointer.touching != chosen[-1][1].touching:
            chosen.append((at, pointer))
    return chosen


def rgb(colour: Sequence[int]) -> str:
    """A colour as a web page writes it."""
    return "#" + "".join(f"{part:02x}" for part in colour[:3])


def _touching(frame: TouchFrame) -> bool:
    return any(pointer.touching for pointer in frame.pointers)


def _radius(pointer: Pointer) -> float:
    return FINGER_MM if pointer.touching else FINGER_MM + 0.15 * pointer.hover_mm


def _fill(pointer: Pointer | None) -> float:
    return 0.55 if pointer is not None and pointer.touching else 0.0


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") or "0"
