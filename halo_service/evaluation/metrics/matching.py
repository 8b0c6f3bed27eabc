"""Which pointer is whose finger, frame by frame: by place alone, each pointer one finger's."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from halo_service.evaluation.metrics.truth import TrueFinger, TrueFrame
from halo_service.values import Pointer, TouchFrame

NEAR_MM = 40.0
"""Chosen: a pointer within this of a finger, in the plane, can be that finger's."""
FAR_MM = 1e6
"""Distance of a pair that cannot be; any number far above the others."""

Pair = tuple[TrueFinger, Pointer]


def pairs(frame: TouchFrame | None, true: TrueFrame | None) -> list[Pair]:
    """Return each finger that has a pointer, with it; as many as there can be, nearest first."""
    if frame is None or true is None or not frame.pointers or not true.fingers:
        return []
    fingers = np.array([(finger.x_mm, finger.y_mm) for finger in true.fingers])
    pointers = np.array([(pointer.x_mm, pointer.y_mm) for pointer in frame.pointers])
    away = np.hypot(*(fingers[:, None, :] - pointers[None, :, :]).transpose(2, 0, 1))
    away[away > NEAR_MM] = FAR_MM
    return [
        (true.fingers[row], frame.pointers[column])
        for row, column in zip(*linear_sum_assignment(away), strict=True)
        if away[row, column] < FAR_MM
    ]
