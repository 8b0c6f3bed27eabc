"""Points on a plane: how one figure became another, what lies within, what repeats. Pure."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.errors import CalibrationError
from halo_service.geometry.camera import Points

EDGE = 1e-3
"""Of an area: the rounding error of a float32 hull."""
TOUCHES = 3
"""Of each place that is touched."""
STEADY_MM = 8.0
"""Touches of one place lie closer to their middle: they err by 5.5 mm (paper 6.2), a finger held
the same way errs alike, and then 2 mm remain."""


@dataclass(frozen=True, slots=True, eq=False)
class Rigid:
    """A turn and a shift, as found from points."""

    there_from_here: Points
    """(3, 3), mm: p_there = M p_here."""
    scale: float
    """How much larger the points lie there than here; left out of the matrix."""
    off_mm: Points
    """(N,) how far each point lies from where the matrix sends it."""


def fit_rigid(here: Points, there: Points) -> Rigid:
    """Fit by least squares (N, 2) points of which N >= 2 differ; never mirrors."""
    middle_here, middle_there = here.mean(axis=0), there.mean(axis=0)
    a = (here - middle_here) @ (1.0, 1j)
    b = (there - middle_there) @ (1.0, 1j)
    turn = np.vdot(a, b)
    scale = float(abs(turn) / np.vdot(a, a).real)
    cos, sin = turn.real / abs(turn), turn.imag / abs(turn)
    matrix = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    matrix[:2, 2] = middle_there - matrix[:2, :2] @ middle_here
    off = here @ matrix[:2, :2].T + matrix[:2, 2] - there
    return Rigid(matrix, scale, np.linalg.norm(off, axis=1))


def inside(points: Points, around: Points) -> NDArray[np.bool_]:
    """(N,) which of (N, 2) points lie in the convex hull of (M, 2) others, its edge included."""
    if len(around) < 3:
        return np.zeros(len(points), dtype=np.bool_)
    corners = cv2.convexHull(around.astype(np.float32)).reshape(-1, 2).astype(np.float64)
    to_next = np.roll(corners, -1, axis=0) - corners
    away = points[:, None] - corners
    side = to_next[:, 0] * away[..., 1] - to_next[:, 1] * away[..., 0]
    return np.asarray((side >= -EDGE).all(axis=1) | (side <= EDGE).all(axis=1))


def steady(what: str, touches: Points) -> Points:
    """(2,) the middle of (N, 2) repeated touches, mm. Raises `CalibrationError` if they differ."""
    if len(touches) < TOUCHES:
        raise CalibrationError(f"{what} was touched {len(touches)} times: touch it {TOUCHES} times")
    middle = np.median(touches, axis=0)
    apart = float(np.linalg.norm(touches - middle, axis=1).max())
    if apart > STEADY_MM:
        raise CalibrationError(
            f"the touches of {what} lie up to {apart:.0f} mm apart: touch it again at the "
            f"same mark, with the same finger held the same way each time"
        )
    return np.asarray(touches.mean(axis=0), dtype=np.float64)
