"""The layout file of a canvas: where the surfaces of nodes and the projectors' pictures are.

Canvas frame: as a surface's, origin at the top left as the user sits, x right, y towards the user,
z into the surface, mm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from annotated_types import Gt, Interval
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, TypeAdapter

from halo_service import toml_file
from halo_service.errors import UserError
from halo_service.geometry.matrix import Matrix3

Matrix = NDArray[np.float64]
Name = Annotated[str, Field(pattern="^[a-z0-9_-]{1,32}$")]
Length = Annotated[float, Gt(0.0)]
LEAST_POINTS = 4
"""Of a homography."""
LEAST_TURN = 0.01
"""Sine of the angle at which three points count as on one line."""


@dataclass(frozen=True, slots=True)
class PlacedSurface:
    """`[[surface]]`: one surface of one node on the canvas."""

    node: Name
    surface: Name = "table"
    x_mm: float = 0.0
    y_mm: float = 0.0
    """Where its (0, 0) is on the canvas."""
    angle_deg: float = 0.0
    """Direction of its x axis on the canvas, clockwise as seen from above."""

    @property
    def canvas_from_surface(self) -> Matrix:
        """(3, 3) rotation and translation, mm: p_canvas = M (x, y, 1)."""
        angle = math.radians(self.angle_deg)
        cos, sin = math.cos(angle), math.sin(angle)
        return np.array([[cos, -sin, self.x_mm], [sin, cos, self.y_mm], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True, eq=False)
class CanvasProjector:
    """`[[projector]]`: where a projector's picture is on the canvas."""

    width_px: Annotated[int, Interval(ge=1, le=65_535)]
    height_px: Annotated[int, Interval(ge=1, le=65_535)]
    name: Annotated[str, Field(pattern="^[a-z0-9_-]{0,31}$")] = ""
    """Its homography is sent on the surface CANVAS-NAME; empty: on the canvas's own."""
    points: tuple[tuple[float, float, float, float], ...] = ()
    """Four or more of x_mm, y_mm on the canvas and x_px, y_px in the picture."""
    projector_from_canvas: Matrix3 | None = None
    """(3, 3) homography, mm -> px, instead of `points`; (0, 0) is the outer corner of the top left
    pixel."""

    @property
    def matrix(self) -> Matrix:
        """(3, 3) homography of the canvas, mm -> px, its last element 1."""
        if self.projector_from_canvas is not None:
            return np.asarray(self.projector_from_canvas / self.projector_from_canvas[2, 2])
        import cv2

        here, there = np.hsplit(np.array(self.points), 2)
        found, _ = cv2.findHomography(here, there, 0)
        return np.asarray(found, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Layout:
    """All of a layout file."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False, arbitrary_types_allowed=True
    )
    """The tables inherit it."""

    width_mm: Length
    height_mm: Length
    surface: tuple[PlacedSurface, ...] = ()
    name: Name = "table"
    """Surface name of the canvas on the wire."""
    projector: tuple[CanvasProjector, ...] = field(default=())

    def surface_name(self, projector: CanvasProjector) -> str:
        """Return the surface that carries a projector's homography."""
        return f"{self.name}-{projector.name}" if projector.name else self.name


ADAPTER = TypeAdapter(Layout)


def load(path: Path) -> Layout:
    """Read a layout file. Raises `UserError`, one line per error."""
    layout = toml_file.read(path, "layout", Layout, ADAPTER)
    if errors := list(_errors(layout)):
        raise UserError("\n".join(f"{path}: {each}" for each in errors))
    return layout


def text(layout: Layout) -> str:
    """Return a layout without projectors as its file has it."""
    lines = [
        f'name = "{layout.name}"',
        f"width_mm = {layout.width_mm}",
        f"height_mm = {layout.height_mm}",
    ]
    for each in layout.surface:
        lines += ["", "[[surface]]", f'node = "{each.node}"', f'surface = "{each.surface}"']
        lines += [f"x_mm = {each.x_mm}", f"y_mm = {each.y_mm}", f"angle_deg = {each.angle_deg}"]
    return "\n".join([*lines, ""])


def _errors(layout: Layout) -> Iterator[str]:
    """Yield what is wrong with values that are right on their own."""
    if not layout.surface:
        yield "the canvas has no surface; add a table [[surface]] for each node"
    placed = [(each.node, each.surface) for each in layout.surface]
    for node, surface in dict.fromkeys(each for each in placed if placed.count(each) > 1):
        yield f"surface '{surface}' of node '{node}' is placed twice; remove one [[surface]]"
    names = [layout.surface_name(each) for each in layout.projector]
    if len(set(names)) < len(names):
        yield "two projectors have one name; give each [[projector]] a 'name' of its own"
    for number, projector in enumerate(layout.projector, 1):
        if len(layout.surface_name(projector)) > 32:
            yield f"projector {number}: 'name' with the canvas's is longer than 31 characters"
        yield from (f"projector {number}: {each}" for each in _projector_errors(projector))


def _projector_errors(projector: CanvasProjector) -> Iterator[str]:
    matrix = projector.projector_from_canvas
    if (matrix is None) == (not projector.points):
        yield "write either 'points' or 'projector_from_canvas'"
    elif matrix is not None:
        if matrix[2, 2] == 0.0 or abs(np.linalg.det(matrix / matrix[2, 2])) < 1e-12:
            yield "'projector_from_canvas' has no inverse; check its numbers"
    elif len(projector.points) < LEAST_POINTS:
        yield f"'points' must be four or more, not {len(projector.points)}"
    elif not all(_spread(half) for half in np.hsplit(np.array(projector.points), 2)):
        yield "'points' must not be on one line; use the corners of the picture"


def _spread(points: Matrix) -> bool:
    """Whether four of (N, 2) points fix a homography: no three of them on one line."""
    return any(
        all(_turn(*three) > LEAST_TURN for three in combinations(four, 3))
        for four in combinations(points[:16], 4)
    )


def _turn(a: Matrix, b: Matrix, c: Matrix) -> float:
    """Return the sine of the angle between two sides of a triangle; 0: on one line."""
    (ux, uy), (vx, vy) = b - a, c - a
    lengths = math.hypot(ux, uy) * math.hypot(vx, vy)
    return abs(ux * vy - uy * vx) / lengths if lengths else 0.0
