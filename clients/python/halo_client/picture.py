"""Transforms millimetres on a surface to pixels of a picture.

Rule: pure. A window shows the whole surface; a projector picture uses the homography, so that
a drawing appears under the finger.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from halo_protocol import Homography

WIDTH_MM, HEIGHT_MM = 300.0, 200.0
"""Size of a surface until a scene reports it."""


@dataclass(frozen=True, slots=True)
class PictureTransform:
    """A projective transform from a surface to a picture."""

    picture_from_surface: tuple[float, ...]
    """9 numbers, row by row: mm -> px, (0, 0) at the outer corner of the first pixel."""

    @classmethod
    def fitted(
        cls, width_px: float, height_px: float, width_mm: float, height_mm: float, margin: float = 0
    ) -> Self:
        """Show the whole surface, centred in a picture, with a margin in px."""
        free_px = (width_px - 2 * margin, height_px - 2 * margin)
        scale = min(free_px[0] / width_mm, free_px[1] / height_mm)
        left, top = (width_px - scale * width_mm) / 2, (height_px - scale * height_mm) / 2
        return cls((scale, 0.0, left, 0.0, scale, top, 0.0, 0.0, 1.0))

    @classmethod
    def projected(cls, homography: Homography, width_px: float, height_px: float) -> Self:
        """For a projector that shows a picture of this size over its whole area."""
        matrix = homography.projector_from_surface
        scales = (width_px / homography.width_px, height_px / homography.height_px, 1.0)
        return cls(tuple(scales[n // 3] * value for n, value in enumerate(matrix)))

    def pixel(self, x_mm: float, y_mm: float) -> tuple[float, float]:
        """The pixel of a point."""
        a, b, c, d, e, f, g, h, i = self.picture_from_surface
        w = g * x_mm + h * y_mm + i
        return (a * x_mm + b * y_mm + c) / w, (d * x_mm + e * y_mm + f) / w

    def scale(self, x_mm: float, y_mm: float) -> float:
        """Pixels per millimetre near a point, averaged over directions."""
        x, y = self.pixel(x_mm, y_mm)
        right, down = self.pixel(x_mm + 1.0, y_mm), self.pixel(x_mm, y_mm + 1.0)
        area = (right[0] - x) * (down[1] - y) - (right[1] - y) * (down[0] - x)
        return math.sqrt(abs(area))
