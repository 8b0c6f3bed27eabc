"""Where two surfaces are relative to each other, by one printed marker that both cameras see."""

from __future__ import annotations

import math

import numpy as np

import halo_protocol as wire
from halo_service.canvas.finding.rigid import rigid
from halo_service.canvas.layout import Matrix

MOST_TILT_DEG, MOST_STEP_MM = 3.0, 10.0
"""Two surfaces of one table agree in direction and height so well."""


class MarkerError(ValueError):
    """Two poses that cannot be of one marker and one table; the text says why."""


def between(here: wire.Pose, there: wire.Pose) -> Matrix:
    """Return the (3, 3) matrix from the surface there to the one here, mm. Raises `MarkerError`."""
    matrix = np.linalg.inv(_full(here)) @ _full(there)
    tilt_deg = math.degrees(math.acos(min(max(float(matrix[2, 2]), -1.0), 1.0)))
    step_mm = abs(float(matrix[2, 3]))
    if tilt_deg > MOST_TILT_DEG or step_mm > MOST_STEP_MM:
        raise MarkerError(
            f"their surfaces would differ by {tilt_deg:.1f} degrees and {step_mm:.0f} mm in height"
        )
    angle = math.atan2(matrix[1, 0] - matrix[0, 1], matrix[0, 0] + matrix[1, 1])
    return rigid(angle, float(matrix[0, 3]), float(matrix[1, 3]))


def _full(pose: wire.Pose) -> Matrix:
    """Return (4, 4) `anchor_from_surface`."""
    rows = np.array(pose.anchor_from_surface, dtype=np.float64).reshape(3, 4)
    return np.vstack([rows, (0.0, 0.0, 0.0, 1.0)])
