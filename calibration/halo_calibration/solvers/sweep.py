"""The sweep: a finger resting on the wedge is drawn over the whole surface. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_calibration.errors import CalibrationError
from halo_calibration.image_places import place
from halo_calibration.observe import Observation
from halo_calibration.solvers.touch import require_frames, require_seen
from halo_service.geometry.surface import Surface
from halo_service.sensing.fingertips import plain_top_mm

SWEEP_S = 20.0
"""The paper's (4.3.5)."""
CELL_MM = 50.0
"""Coverage is counted in cells of 5 cm: the halo changes slowly over the surface."""
CELL_SAMPLES = 3
"""Frames that make a cell covered: a tenth of a second at 30 a second."""
LEAST_COVERED = 0.6
GOOD_COVERED = 0.85
"""Share of the cells."""
LIFTED = 0.2
"""A sample below this share of a strong one is a finger that was lifted (chosen: the halo of a
touch may be four times as weak in a corner)."""
MOST_LIFTED = 0.25
"""More of these, and the finger was not on the surface."""

Samples = NDArray[np.float64]
"""(N, 9): x and y in mm, pitch and yaw in degrees, raw signal in mm px, the other readings and the
height of the finger's upper side in mm, as at 45 degrees to the line of sight; nan where one was
hidden."""
COLUMNS = 9
READINGS, TOP = range(4, 8), 8
"""Which columns are readings of the halo, and which is the upper side."""


@dataclass(frozen=True, slots=True, eq=False)
class SweepObservations:
    """What was observed during a sweep."""

    expected: int
    """Frames that the camera should have given in that time."""
    received: int
    observations: tuple[Observation, ...]


def samples_of(observations: Sequence[Observation]) -> Samples:
    """Return the observations as an array."""
    rows = [
        (
            each.x_mm,
            each.y_mm,
            each.pitch_deg,
            each.yaw_deg,
            *each.readings,
            # By an assumed angle it would say nothing of the place.
            math.nan if math.isnan(each.seen_deg) else plain_top_mm(each.top_mm, each.seen_deg),
        )
        for each in observations
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, COLUMNS)


def covered(samples: Samples, surface: Surface) -> NDArray[np.int_]:
    """Count the samples in each cell; (rows, columns), far edge first."""
    columns = max(round(surface.width_mm / CELL_MM), 1)
    rows = max(round(surface.height_mm / CELL_MM), 1)
    counts, _, _ = np.histogram2d(
        samples[:, 1],
        samples[:, 0],
        bins=(rows, columns),
        range=((0.0, surface.height_mm), (0.0, surface.width_mm)),
    )
    return np.asarray(counts, dtype=np.int_)


def check_sweep(swept: SweepObservations, surface: Surface, step: str = "sweep") -> Samples:
    """Return the usable samples. Raises `CalibrationError` if too few, or they cover too little."""
    require_frames(step, swept.expected, swept.received)
    require_seen(step, swept.received, len(swept.observations))
    samples = samples_of(swept.observations)
    lifted = ~rests(samples)
    if np.count_nonzero(lifted) > MOST_LIFTED * len(samples):
        share = 100.0 * np.count_nonzero(lifted) / len(samples)
        raise CalibrationError(
            f"the finger was off the surface in {share:.0f} % of the sweep: rest it on the wedge, "
            f"keep its tip on the surface, and sweep again"
        )
    samples = np.asarray(samples[~lifted], dtype=np.float64)
    counts = covered(samples, surface)
    share = coverage(counts)
    if share < LEAST_COVERED:
        raise CalibrationError(
            f"the sweep covered only {100.0 * share:.0f} % of the surface; missing most "
            f"{_missing(counts)}: draw the finger over all of it, out to the edges, and sweep again"
        )
    return samples


def rests(samples: Samples) -> NDArray[np.bool_]:
    """Return which samples are of a finger on the surface; a quarter of them must be."""
    return np.asarray(samples[:, 4] > LIFTED * np.percentile(samples[:, 4], 75.0))


def coverage(counts: NDArray[np.int_]) -> float:
    """Return the share of cells that are covered."""
    return float(np.mean(counts >= CELL_SAMPLES))


def draw_map(counts: NDArray[np.int_]) -> list[str]:
    """Draw what is covered, one line a row of cells, far edge first."""
    return [
        "".join("██" if n >= CELL_SAMPLES else "░░" if n else "··" for n in row) for row in counts
    ]


def _missing(counts: NDArray[np.int_]) -> str:
    """Name the ninth of the surface with the most cells uncovered."""
    rows, columns = counts.shape
    tally: dict[str, int] = {}
    for row, column in np.argwhere(counts < CELL_SAMPLES):
        word = place((column + 0.5) / columns, (row + 0.5) / rows)
        tally[word] = tally.get(word, 0) + 1
    return max(tally, key=lambda word: tally[word])
