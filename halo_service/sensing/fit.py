"""Whether the empty surface is still where the profile has it.

Rule: pure, and cheap: on every sixteenth pixel in both directions, 0.3 ms a frame. Hands may be
in view. A device that warms up shifts all pixels alike, which the sensing follows (see
`background.follow_drift`); a tilt and a large shift are more than warming up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.profile import Profile
from halo_service.sensing.background import DRIFT_GRID
from halo_service.values import Depth

MOVED_MM = 8.0
"""A device that warms up shifts by less (chosen; data sheets say 2 to 5 mm)."""
TILTED_DEG = 0.5
"""The corner of a surface of 300 x 200 mm is then off by 1.5 mm, which is a finger's halo."""
NEAR_MM = (40.0, 10.0, 6.0)
"""What differs from the plane by more is hand or object; from fit to fit the plane is known better,
the last is also what counts as surface."""
LEAST_SHARE = 0.5
"""Of the background's pixels; two arms hide less than half."""


@dataclass(frozen=True, slots=True)
class SurfaceFit:
    """How one frame differs from the background of the profile."""

    moved_mm: float
    """How much farther the surface is."""
    tilted_deg: float
    share: float
    """Of the background's pixels that show a surface there, 0 to 1."""

    @property
    def recognised(self) -> bool:
        """Whether enough of the surface is visible to judge it."""
        return self.share >= LEAST_SHARE

    @property
    def good(self) -> bool:
        """Whether the profile fits."""
        in_place = abs(self.moved_mm) < MOVED_MM and self.tilted_deg < TILTED_DEG
        return self.recognised and in_place


def surface_fit(depth: Depth, profile: Profile) -> SurfaceFit:
    """Compare a frame with the background. `depth`: (H, W) uint16 mm, 0 = unmeasured."""
    background, lens = profile.background, profile.camera.depth
    valid = background.valid[DRIFT_GRID]
    rows, columns = np.nonzero(valid)
    seen = depth[DRIFT_GRID][valid].astype(np.float64)
    mean_mm = background.mean_mm[DRIFT_GRID][valid]
    step = DRIFT_GRID[0].step
    x, y = (columns * step - lens.cx) / lens.fx, (rows * step - lens.cy) / lens.fy
    directions = np.column_stack([np.ones(len(x)), x, y])[seen > 0]
    off_mm = (seen - mean_mm)[seen > 0]
    if len(off_mm) < LEAST_SHARE * len(seen) or len(seen) == 0:
        return SurfaceFit(0.0, 0.0, len(off_mm) / max(len(seen), 1))
    plane = np.array([np.median(off_mm), 0.0, 0.0])
    for near_mm in NEAR_MM[:-1]:
        plane = _refined(plane, directions, off_mm, near_mm)
    surface = np.abs(off_mm - directions @ plane) < NEAR_MM[-1]
    tilt = np.hypot(plane[1], plane[2]) / float(np.median(mean_mm))
    share = np.count_nonzero(surface) / len(seen)
    return SurfaceFit(float(plane[0]), float(np.degrees(np.arctan(tilt))), float(share))


def _refined(
    plane: NDArray[np.float64],
    directions: NDArray[np.float64],
    off_mm: NDArray[np.float64],
    near_mm: float,
) -> NDArray[np.float64]:
    """Fit the plane again, through what is near it."""
    near = np.abs(off_mm - directions @ plane) < near_mm
    if np.count_nonzero(near) < directions.shape[1]:
        return plane
    return np.asarray(np.linalg.lstsq(directions[near], off_mm[near], rcond=None)[0])
