"""Two figures on one plane, and how one was turned and shifted to become the other. Pure."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from halo_service.geometry.camera import Points


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


def hull_area(points: Points) -> float:
    """Area of the convex hull of (N, 2) points; 0 for fewer than three."""
    return 0.0 if len(points) < 3 else float(cv2.contourArea(hull(points).astype(np.float32)))


def hull(points: Points) -> Points:
    """(M, 2) corners of the convex hull, in order."""
    around = cv2.convexHull(points.astype(np.float32))
    return np.asarray(around, dtype=np.float64).reshape(-1, 2)


def common(a: Points, b: Points) -> Points:
    """(M, 2) corners of what the convex hulls of two sets of points share; (0, 2) for nothing."""
    if len(a) < 3 or len(b) < 3:
        return np.empty((0, 2))
    area, shared = cv2.intersectConvexConvex(hull(a).astype(np.float32), hull(b).astype(np.float32))
    return np.asarray(shared, dtype=np.float64).reshape(-1, 2) if area > 0.0 else np.empty((0, 2))
