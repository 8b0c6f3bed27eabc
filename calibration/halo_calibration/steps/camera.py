"""Whether a camera is placed well: its height and tilt, what it measures, how bright it is.

Rule: as `steps`: no prompts, no frames fetched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.background import solve_background
from halo_calibration.solvers.plane import Plane, solve_plane
from halo_calibration.steps.change import rounded
from halo_service.geometry.camera import Camera
from halo_service.profile import StepRecord
from halo_service.profile.model import Quality
from halo_service.values import Frame, Infrared

LOWEST_MM, HIGHEST_MM = 400.0, 1000.0
"""Tested heights are 450 to 1000 mm; nearer a hand leaves the picture, farther the halo drowns."""
STEEP_DEG = 35.0
"""More tilt leaves little of the halo behind the finger visible."""
LEAST_MEASURED = 0.95
"""Share of the middle half that should give a depth."""
SATURATED = 65_535
MOST_SATURATED = 0.01
LOOK_S = 2.1
"""A little more than the frames that a background needs."""
ROWS, COLUMNS = 8, 12
"""Of the map."""
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
    map: tuple[str, ...]
    """What of the picture is measured, a line a row; see `MAP`."""

    def record(self, date: str) -> StepRecord:
        """Return what a profile stores of it."""
        figures = rounded(
            height_mm=self.height_mm,
            tilt_deg=self.tilt_deg,
            measured_share=self.measured_share,
            infrared=self.infrared,
            saturated_share=self.saturated_share,
        )
        return StepRecord(date, self.quality, figures, " ".join(self.advice).rstrip("."))


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
        _map(background.valid, frames[-1].ir),
    )


MAP = "█ measured   ░ too dark   ☼ too bright   · not measured"
"""What the marks of a map mean."""


def _map(valid: NDArray[np.bool_], infrared: Infrared) -> tuple[str, ...]:
    """Mark each part of the picture by what most of its pixels are."""
    bright = infrared >= SATURATED
    dark = valid & (infrared < DARK_COUNTS)
    kinds = {"█": valid & ~bright & ~dark, "☼": bright, "░": dark, "·": ~valid & ~bright}

    def mark(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> str:
        part = np.ix_(rows, columns)
        return 2 * max(kinds, key=lambda each: float(np.mean(kinds[each][part])))

    rows, columns = (np.arange(length) for length in valid.shape)
    return tuple(
        "".join(mark(row, column) for column in np.array_split(columns, COLUMNS))
        for row in np.array_split(rows, ROWS)
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
