"""Which pointer belongs to which finger in a frame: by place alone, each pointer to one finger."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from halo_service.evaluation.metrics.truth import TrueFinger, TrueFrame
from halo_service.values import Pointer, TouchFrame

NEAR_MM = 40.0
"""Chosen: a pointer within this of a finger, in the plane, can be that finger's."""
IMPOSSIBLE_MM = 1e6
"""Distance of a pair that cannot match; any number far above the others."""

Pair = tuple[TrueFinger, Pointer]


def match_pointers(frame: TouchFrame | None, true: TrueFrame | None) -> list[Pair]:
    """Return the pairs of finger and pointer: as many as possible, with the least distance."""
    if frame is None or true is None or not frame.pointers or not true.fingers:
        return []
    away = cdist(
        [(finger.x_mm, finger.y_mm) for finger in true.fingers],
        [(pointer.x_mm, pointer.y_mm) for pointer in frame.pointers],
    )
    away = np.where(away > NEAR_MM, IMPOSSIBLE_MM, away)
    return [
        (true.fingers[row], frame.pointers[column])
        for row, column in zip(*linear_sum_assignment(away), strict=True)
        if away[row, column] < IMPOSSIBLE_MM
    ]
