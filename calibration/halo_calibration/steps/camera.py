"""Whether a camera is placed well: its height and tilt, what it measures, how bright it is.

Rule: as `steps`: no prompts, no frames fetched; nothing is stored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.background import solve_background
from halo_calibration.solvers.plane import Plane, solve_plane
from halo_service.geometry.camera import Camera
from halo_service.profile.model import Quality
from halo_service.values import Frame

LOWEST_MM, HIGHEST_MM = 400.0, 1000.0
"""Tested heights are 450 to 1000 mm; nearer a hand leaves the picture, farther the halo drowns."""
STEEP_DEG = 35.0
"""More tilt leaves little of the halo behind the finger visible."""
LEAST_MEASURED = 0.95
"""Share of the middle half that should give a depth."""
SATURATED = 65_535
MOST_SATURATED = 0.01
DARK_COUNTS = 60
"""Infrared in the middle, below which the depth's noise hides a halo (chosen)."""


@dataclass(frozen=True, slots=True)
class CameraReport:
    """How a camera is placed."""

    height_mm: float
    """From the lens to the table along the optical axis."""
    tilt_deg: float
    """0: straight down."""
    measured_share: float
    """Of the middle half of the picture."""
    infrared: float
    """Median there, counts."""
    saturated_share: float
    quality: Quality
    advice: tuple[str, ...]
    """What to change; empty: nothing."""


def camera_report(frames: Sequence[Frame], camera: Camera) -> CameraReport:
    """Judge the placement from frames of the empty table. Raises `CalibrationError`."""
    if not frames:
        raise CalibrationError("the camera gives no frames: check its cable")
    background = solve_background([each.depth for each in frames], [each.ir for each in frames])
    plane = solve_plane(background, camera)
    rows, columns = background.valid.shape
    middle = (slice(rows // 4, 3 * rows // 4), slice(columns // 4, 3 * columns // 4))
    infrared = frames[-1].ir[middle]
    measured = float(np.mean(background.valid[middle]))
    saturated = float(np.mean(infrared >= SATURATED))
    level = float(np.median(infrared))
    advice = _advice(plane, measured, saturated, level)
    return CameraReport(
        plane.distance_mm,
        plane.tilt_deg,
        measured,
        level,
        saturated,
        "fair" if advice else "good",
        advice,
    )


def _advice(plane: Plane, measured: float, saturated: float, level: float) -> tuple[str, ...]:
    """Return a sentence for each thing to change."""
    rules = (
        (
            plane.distance_mm < LOWEST_MM,
            f"The camera is only {plane.distance_mm / 10:.0f} cm above the table: raise it to 45 "
            f"to 70 cm.",
        ),
        (
            plane.distance_mm > HIGHEST_MM,
            f"The camera is {plane.distance_mm / 10:.0f} cm above the table, and the halo fades "
            f"with distance: lower it to 45 to 70 cm.",
        ),
        (
            plane.tilt_deg > STEEP_DEG,
            f"The camera is tilted by {plane.tilt_deg:.0f} degrees: let it look down more steeply.",
        ),
        (
            saturated > MOST_SATURATED,
            f"Too bright: {100 * saturated:.0f} % of the middle saturates. Remove what shines, use "
            f"a matt surface, or raise the camera.",
        ),
        (
            level < DARK_COUNTS,
            "Too dark: the surface reflects little infrared. Put a lighter, matt cloth or paper "
            "there, or lower the camera.",
        ),
        (
            measured < LEAST_MEASURED,
            f"Only {100 * measured:.0f} % of the middle is measured: remove glass and mirrors, and "
            f"keep sunlight off the table.",
        ),
    )
    return tuple(words for applies, words in rules if applies)
