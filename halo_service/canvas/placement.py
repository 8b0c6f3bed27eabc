"""Whether the surfaces of a layout overlap and are on the canvas.

Rule: pure. The sizes of surfaces are known when their scenes have arrived.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from halo_service.canvas.detections import Area
from halo_service.canvas.layout import Layout

LEAST_OVERLAP_MM = 40.0
"""A camera needs some frames to find a finger that comes in."""
MOST_OUTSIDE_MM = 20.0
"""A surface at a small angle has corners a few mm outside."""


def placement_warnings(layout: Layout, areas: Sequence[Area]) -> Iterator[str]:
    """Yield a sentence for each surface that is placed wrongly. All sizes must be known."""
    for area in areas:
        name = "/".join(area.surface)
        others = [overlap_mm(area, other) for other in areas if other is not area]
        if others and round(max(others)) < LEAST_OVERLAP_MM:
            by = f"by {max(others):.0f} mm only" if max(others) > 0.0 else "with no other surface"
            yield (
                f"{name} overlaps {by}: touches need {LEAST_OVERLAP_MM:.0f} mm to go on from one "
                "camera to the next; correct x_mm, y_mm and angle_deg in the layout, or move a "
                "camera"
            )
        outside_mm = _outside_mm(layout, area)
        if outside_mm > MOST_OUTSIDE_MM:
            yield (
                f"{name} reaches {outside_mm:.0f} mm beyond the canvas; correct width_mm and "
                "height_mm, or x_mm and y_mm, in the layout"
            )


def overlap_mm(a: Area, b: Area) -> float:
    """Return the width of the strip that two surfaces share; negative: the gap between them.

    Two rectangles are apart if they are apart along a side of one of them.
    """
    corners = np.array(a.corners_mm()), np.array(b.corners_mm())
    sides = np.vstack([each.canvas_from_surface[:2, :2].T for each in (a, b)])
    ones, others = (sides @ each.T for each in corners)
    shared = np.minimum(ones.max(1), others.max(1)) - np.maximum(ones.min(1), others.min(1))
    return float(shared.min())


def _outside_mm(layout: Layout, area: Area) -> float:
    corners = np.array(area.corners_mm())
    return float(np.max([-corners, corners - (layout.width_mm, layout.height_mm)]))
