"""A rotation and a translation from pairs of places, some of them wrong.

Rule: pure. Two pairs propose each fit; the one with most pairs near to it is fitted again by least
squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from halo_service.canvas.layout import Matrix

Places = NDArray[np.float64]
NEAR_MM = 8.0
"""A pair that is farther off is wrong: two cameras see one touch within 3 mm each."""
LEAST = 3
"""Pairs that must agree: two fit always."""
APART_MM = 15.0
"""Two places nearer to each other propose no direction."""


@dataclass(frozen=True, slots=True)
class RigidFit:
    """Where one surface is on another."""

    matrix: Matrix
    """(3, 3) rotation and translation, mm."""
    off_mm: float
    """Root mean square distance of the pairs that agree, after the fit."""
    used: tuple[bool, ...]
    """Which pairs agree."""
    middle_mm: tuple[float, float]
    """Of the places on the other surface that agree."""
    spread_mm: float
    """How far these are apart: root mean square distance from their middle."""

    @property
    def count(self) -> int:
        """Number of pairs that agree."""
        return sum(self.used)

    @property
    def angle_deg(self) -> float:
        """Direction of the x axis."""
        return math.degrees(math.atan2(self.matrix[1, 0], self.matrix[0, 0]))

    def error_mm(self, place_mm: tuple[float, float]) -> float:
        """Return the standard deviation of the fit at a place of the other surface.

        A place's error counts with its part in the residuals: n pairs have 2 n - 3 free numbers.
        """
        free = max(2 * self.count - 3, 1)
        sigma_mm = self.off_mm * math.sqrt(self.count / free)
        away = math.dist(place_mm, self.middle_mm) / max(self.spread_mm, 1.0)
        return sigma_mm * math.sqrt((1.0 + away**2) / self.count)


def fit(here: Places, there: Places) -> RigidFit | None:
    """Return the (3, 3) matrix from there to here; None where fewer than three pairs agree.

    `here`, `there`: (N, 2) mm, the same places on two surfaces.
    """
    best: NDArray[np.bool_] | None = None
    for i, j in combinations(range(len(here)), 2):
        if math.dist(there[i], there[j]) < APART_MM:
            continue
        near = _off(_solved(here[[i, j]], there[[i, j]]), here, there) < NEAR_MM
        if best is None or np.count_nonzero(near) > np.count_nonzero(best):
            best = near
    if best is None or np.count_nonzero(best) < LEAST:
        return None
    matrix = _solved(here[best], there[best])
    best = _off(matrix, here, there) < NEAR_MM
    if np.count_nonzero(best) < LEAST:
        return None
    matrix = _solved(here[best], there[best])
    middle = there[best].mean(axis=0)
    return RigidFit(
        matrix,
        float(np.sqrt(np.mean(_off(matrix, here[best], there[best]) ** 2))),
        tuple(map(bool, best)),
        (float(middle[0]), float(middle[1])),
        float(np.sqrt(np.mean(np.sum((there[best] - middle) ** 2, axis=1)))),
    )


def rigid(angle_rad: float, x_mm: float, y_mm: float) -> Matrix:
    """Return the (3, 3) matrix of a rotation and a translation."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, -sin, x_mm], [sin, cos, y_mm], [0.0, 0.0, 1.0]])


def _solved(here: Places, there: Places) -> Matrix:
    """Return the least squares rotation and translation (Kabsch, in two dimensions)."""
    middle_here, middle_there = here.mean(axis=0), there.mean(axis=0)
    a, b = there - middle_there, here - middle_here
    angle = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    turn = rigid(angle, 0.0, 0.0)[:2, :2]
    x, y = middle_here - turn @ middle_there
    return rigid(angle, float(x), float(y))


def _off(matrix: Matrix, here: Places, there: Places) -> NDArray[np.float64]:
    """Return (N,) mm: how far the pairs are off."""
    off = there @ matrix[:2, :2].T + matrix[:2, 2] - here
    return np.asarray(np.linalg.norm(off, axis=1))
