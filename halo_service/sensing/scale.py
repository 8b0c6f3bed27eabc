"""How large a millimetre is in the image: a camera may hang at any height, with any lens."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

from halo_service.profile import Profile
from halo_service.sensing.finger_frame import Pixel
from halo_service.values import Depth

WINDOW_PX = 3
"""Half the window around a place, for a depth that one missing pixel does not change."""
LEAST_SHARE = 0.4
"""What is nearer than this share of the way to the surface is not a hand over it."""
FACING = (0.5, 1.5)
"""Bounds for a ray's part along the surface's normal: far outside the image it is not a ray."""


def on_surface(profile: Profile) -> float:
    """Return the size of a millimetre on the surface, px."""
    return profile.camera.depth.fx / max(float(profile.surface.camera_from_surface[2, 3]), 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Scale:
    """The scale of one frame."""

    depth: Depth
    profile: Profile

    @property
    def on_surface(self) -> float:
        """Return the scale on the surface."""
        return on_surface(self.profile)

    def px_per_mm(self, at_px: Pixel) -> float:
        """Return the scale at the depth of what is seen at a place, else at the surface's."""
        lens, pose = self.profile.camera.depth, self.profile.surface.camera_from_surface
        normal, origin = pose[:3, 2], pose[:3, 3]
        ray = ((at_px[0] - lens.cx) / lens.fx, (at_px[1] - lens.cy) / lens.fy, 1.0)
        facing = min(max(float(normal @ ray), FACING[0]), FACING[1])
        surface_mm = max(float(normal @ origin), 1.0) / facing
        seen_mm = self._seen_mm(at_px)
        return lens.fx / min(max(seen_mm or surface_mm, LEAST_SHARE * surface_mm), surface_mm)

    def _seen_mm(self, at_px: Pixel) -> float:
        """Return the depth around a place, 0 where nothing is measured."""
        column, row = round(at_px[0]), round(at_px[1])
        rows = slice(max(row - WINDOW_PX, 0), max(row + WINDOW_PX + 1, 0))
        window = self.depth[rows, max(column - WINDOW_PX, 0) : max(column + WINDOW_PX + 1, 0)]
        measured = window[window > 0].tolist()
        # NumPy's median costs five times as much on so few pixels, ten times a frame.
        return float(median(measured)) if measured else 0.0
