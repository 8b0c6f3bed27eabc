"""A node's pointer and its events, in the place and time of the canvas."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

import halo_protocol as wire
from halo_service.canvas.layout import Matrix, PlacedSurface

Place = tuple[float, float]
SurfaceKey = tuple[str, str]
"""(node, surface)."""
Member = tuple[SurfaceKey, int]
"""One pointer of one surface, by its id."""

PLACE_MM = 2.0
"""Standard deviation of a pointer's place in the middle of a surface."""
LEAST_CONFIDENCE = 0.05
WEAK_CONFIDENCE = 0.4
"""Below, a node moves a pointer on that it does not see, or has just found one at its edge."""
EDGE_TIMES, EDGE_MM = 3.0, 15.0
"""Added deviation at the edge, as a multiple, and the distance inwards at which it has fallen to
1/e."""
OUTSIDE_MM = 30.0
"""Distance outside from which on the deviation does not grow any more."""
LONGEST_S = 0.1
"""Longest time for which a pointer is predicted by its velocity: three frames."""


@dataclass(frozen=True, slots=True)
class Detection:
    """What one node reports of one finger."""

    member: Member
    time_us: int
    """On the canvas's clock."""
    place_mm: Place
    velocity_mm_s: Place
    deviation_mm: float
    """Standard deviation of the place."""
    pointer: wire.Pointer
    """As the node sent it."""

    @property
    def name(self) -> tuple[int, int]:
        """Its hand and finger, as the node reports them."""
        return self.pointer.hand, self.pointer.finger

    @property
    def weak(self) -> bool:
        """Whether the node hardly sees the finger."""
        return self.pointer.confidence < WEAK_CONFIDENCE

    def is_weaker(self, other: Detection) -> bool:
        """Whether both are weak, and this one is not seen better than the other."""
        return self.weak and self.pointer.confidence <= other.pointer.confidence

    def coasts(self, now: Detection) -> bool:
        """Whether a newer report repeats this one: the node does not see the finger now."""
        same = (self.pointer.x_mm, self.pointer.y_mm) == (now.pointer.x_mm, now.pointer.y_mm)
        return same and now.pointer.confidence < self.pointer.confidence

    def coasting(self, now: Detection) -> Detection:
        """Return this report with all of a newer one but its place, which is this one's."""
        return replace(self, deviation_mm=now.deviation_mm, pointer=now.pointer)

    def at(self, time_us: int) -> Place:
        """Return where the finger is at a time."""
        s = min(max(time_us - self.time_us, 0) / 1e6, LONGEST_S)
        (x, y), (vx, vy) = self.place_mm, self.velocity_mm_s
        return x + s * vx, y + s * vy


@dataclass(frozen=True, slots=True)
class NodeEvent:
    """A down or up of a node."""

    time_us: int
    place_mm: Place
    strike_mm_s: float = wire.UNKNOWN_STRIKE


class Area:
    """One placed surface; its size is known when its scene has arrived."""

    def __init__(self, placed: PlacedSurface) -> None:
        self.surface: SurfaceKey = (placed.node, placed.surface)
        self.canvas_from_surface = placed.canvas_from_surface
        """(3, 3), mm."""
        self._surface_from_canvas = np.linalg.inv(self.canvas_from_surface)
        self.size_mm: Place | None = None

    def detection(self, pointer: wire.Pointer, time_us: int) -> Detection:
        """Return a pointer of this surface on the canvas."""
        place_mm = mapped(self.canvas_from_surface, (pointer.x_mm, pointer.y_mm))
        velocity = self.canvas_from_surface[:2, :2] @ (pointer.vx_mm_s, pointer.vy_mm_s)
        edge_mm = self.inside_mm(place_mm)
        deviation_mm = PLACE_MM / min(max(pointer.confidence, LEAST_CONFIDENCE), 1.0)
        deviation_mm *= 1.0 + EDGE_TIMES * math.exp(-max(edge_mm, -OUTSIDE_MM) / EDGE_MM)
        member = (self.surface, pointer.id)
        return Detection(
            member,
            time_us,
            place_mm,
            (float(velocity[0]), float(velocity[1])),
            deviation_mm,
            pointer,
        )

    def event(self, event: wire.Down | wire.Up, frame_us: int) -> NodeEvent:
        """Return an event of this surface on the canvas; `frame_us`: of its frame."""
        width_mm, height_mm = self.size_mm or (0.0, 0.0)
        place_mm = mapped(self.canvas_from_surface, (event.u * width_mm, event.v * height_mm))
        strike = event.strike_mm_s if isinstance(event, wire.Down) else wire.UNKNOWN_STRIKE
        return NodeEvent(frame_us - round(event.ago_ms * 1000.0), place_mm, strike)

    def inside_mm(self, place_mm: Place) -> float:
        """Return how far inside of the surface a place is; negative outside; inf: size unknown."""
        if self.size_mm is None:
            return math.inf
        x, y = mapped(self._surface_from_canvas, place_mm)
        width_mm, height_mm = self.size_mm
        return min(x, y, width_mm - x, height_mm - y)

    def corners_mm(self) -> list[Place]:
        """Return the four corners on the canvas; empty while the size is unknown."""
        if self.size_mm is None:
            return []
        w, h = self.size_mm
        corners = ((0.0, 0.0), (w, 0.0), (w, h), (0.0, h))
        return [mapped(self.canvas_from_surface, each) for each in corners]


def mapped(matrix: Matrix, place_mm: Place) -> Place:
    """Map a place by a (3, 3) rotation and translation."""
    x, y = place_mm
    return (
        float(matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]),
        float(matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]),
    )
