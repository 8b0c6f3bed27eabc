"""Makes a layout from how pairs of surfaces are placed relative to each other.

Rule: pure. The first surface keeps its direction; each further one is placed by the pair with the
smallest error that reaches it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from halo_service.canvas.detections import Place, SurfaceKey, mapped
from halo_service.canvas.layout import Layout, Matrix, PlacedSurface


@dataclass(frozen=True, slots=True)
class Between:
    """Where the surface `there` is on the surface `here`."""

    here: SurfaceKey
    there: SurfaceKey
    here_from_there: Matrix
    error_mm: float

    def turned(self) -> Between:
        """Return the same from the other side."""
        return Between(self.there, self.here, np.linalg.inv(self.here_from_there), self.error_mm)


def placed(
    sizes_mm: Mapping[SurfaceKey, Place], pairs: Sequence[Between], name: str = "table"
) -> tuple[Layout, list[SurfaceKey]]:
    """Return the layout, and the surfaces that no pair reaches, which it leaves out."""
    both = [*pairs, *(each.turned() for each in pairs)]
    first = next(iter(sizes_mm))
    at: dict[SurfaceKey, Matrix] = {first: np.eye(3)}
    while steps := [each for each in both if each.here in at and each.there not in at]:
        best = min(steps, key=lambda each: each.error_mm)
        at[best.there] = at[best.here] @ best.here_from_there
    corners = [
        mapped(at[surface], corner)
        for surface, (w, h) in sizes_mm.items()
        if surface in at
        for corner in ((0.0, 0.0), (w, 0.0), (w, h), (0.0, h))
    ]
    left, top = (min(each[axis] for each in corners) for axis in (0, 1))
    right, bottom = (max(each[axis] for each in corners) for axis in (0, 1))
    surfaces = tuple(
        PlacedSurface(
            node,
            surface,
            round(float(matrix[0, 2]) - left, 2),
            round(float(matrix[1, 2]) - top, 2),
            round(math.degrees(math.atan2(matrix[1, 0], matrix[0, 0])), 3),
        )
        for (node, surface), matrix in at.items()
    )
    layout = Layout(round(right - left, 1), round(bottom - top, 1), surfaces, name)
    return layout, [surface for surface in sizes_mm if surface not in at]
