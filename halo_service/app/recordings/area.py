"""A smaller recording: the calibrated surface and what is near it, and little of the rest.

Rule: what is left out is 0, which is "not measured". The pixels by which drift and fit of the
profile are judged stay everywhere, so that a replay senses and warns as with the whole image.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Profile
from halo_service.sensing.background import DRIFT_GRID
from halo_service.values import Frame

MARGIN_MM = 80.0
"""Around the surface: a hand whose finger touches the edge is in the image as far as its wrist."""


class AreaCut:
    """Cuts frames of one camera."""

    def __init__(self, profile: Profile) -> None:
        self._inside = near_surface(profile)
        self._inside[DRIFT_GRID] = True

    def cut(self, frame: Frame) -> Frame:
        """Return the frame without what is far from the surface, and without colour."""
        depth, ir = (np.where(self._inside, each, 0) for each in (frame.depth, frame.ir))
        return replace(frame, depth=depth.astype(np.uint16), ir=ir.astype(np.uint16), colour=None)


def near_surface(profile: Profile) -> NDArray[np.bool_]:
    """Return which pixels of the depth image see the surface or a place near it: (H, W)."""
    lens, surface = profile.camera.depth, profile.surface
    rows, columns = np.mgrid[0 : lens.height, 0 : lens.width]
    px = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
    x_mm, y_mm = surface.seen_at(px, lens, np.eye(4)).T
    inside = np.abs(x_mm - surface.width_mm / 2.0) < surface.width_mm / 2.0 + MARGIN_MM
    inside &= np.abs(y_mm - surface.height_mm / 2.0) < surface.height_mm / 2.0 + MARGIN_MM
    return np.asarray(inside.reshape(lens.height, lens.width), dtype=np.bool_)
