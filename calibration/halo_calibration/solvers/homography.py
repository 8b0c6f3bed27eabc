"""A homography from point pairs, and its quality. Pure.

Rule: robust first, exact then, refused where the points do not say enough: too many contradict,
they lie in a line, or show a mirrored picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.rigid2d import inside
from halo_service.geometry.camera import Points
from halo_service.geometry.surface import Surface
from halo_service.profile import Projector
from halo_service.values import Pixels

LEAST_INLIERS = 0.7
"""Share of inliers; below it, the inliers cannot be trusted."""
THIN = 0.1
"""Width over length of a cloud of points below which they are in a line."""
LIT = 0.1
"""Of the surface, which the pattern must light at least."""
ROUNDS = 3
"""Of least squares on the inliers; it converges after two."""
DOF = 4
"""Points that a homography fits whatever they are."""


@dataclass(frozen=True, slots=True, eq=False)
class HomographyFit:
    """A projector's homography, and how well the points agree with it."""

    projector: Projector
    error_px: float
    """Root mean square over the points used, with what the fit took from it given back."""
    error_mm: float
    """The same on the surface."""
    off_px: Points
    """(N,) of each point that was seen, outliers too."""
    off_mm: Points
    """Likewise, on the surface."""
    names: tuple[str, ...]
    """Of the marks, in the same order."""
    outliers: tuple[str, ...]
    """Names of the points that took no part."""
    covered: float
    """Share of the surface under the pattern where points were seen."""


@dataclass(frozen=True, slots=True, eq=False)
class PointPairs:
    """What one way of looking knows."""

    surface: Points
    """(N, 2) mm."""
    projector: Pixels
    """(N, 2) px."""
    names: Sequence[str]
    offered: Pixels
    """(M, 2) px of all points there were to be seen."""


def solve(
    known: PointPairs, size: tuple[int, int], surface: Surface, outlier_px: float
) -> HomographyFit:
    """Fit a projector's picture of a size in px to points. Raises `CalibrationError`.

    `outlier_px`: what lies farther from the fit takes no part in it.
    """
    here, there = known.surface, known.projector
    _require_spread(here)
    _require_spread(there)
    matrix, used = _robust(here, there, outlier_px)
    if matrix is None or np.mean(used) < LEAST_INLIERS:
        raise CalibrationError(_contradiction(known, used, outlier_px))
    _require_spread(here[used])
    off_px = np.linalg.norm(mapped(matrix, here) - there, axis=1)
    off_mm = np.linalg.norm(mapped(np.linalg.inv(matrix), there) - here, axis=1)
    free = max(int(np.count_nonzero(used)) - DOF, 1)
    return HomographyFit(
        Projector(size[0], size[1], matrix),
        error_px=float(np.sqrt(np.sum(off_px[used] ** 2) / free)),
        error_mm=float(np.sqrt(np.sum(off_mm[used] ** 2) / free)),
        off_px=off_px,
        off_mm=off_mm,
        names=tuple(known.names),
        outliers=_left_out(known, used),
        covered=_covered(matrix, known, here[used], surface),
    )


def _robust(
    here: Points, there: Pixels, outlier_px: float
) -> tuple[Points | None, NDArray[np.bool_]]:
    """(3, 3) homography with last element 1, and which points are inliers."""
    # MAGSAC++ finds who agrees, with a seed of its own that never changes; it knows no mirrors.
    # Least squares then fits them.
    found, _ = cv2.findHomography(
        here, there, cv2.USAC_MAGSAC, ransacReprojThreshold=outlier_px, maxIters=5000,
        confidence=0.9999,
    )  # fmt: skip
    used = np.zeros(len(here), dtype=np.bool_)
    for _ in range(ROUNDS):
        if found is None:
            return None, used
        off = mapped(np.asarray(found, dtype=np.float64), here) - there
        used = np.linalg.norm(off, axis=1) < outlier_px
        if np.count_nonzero(used) < DOF:
            return None, used
        found, _ = cv2.findHomography(here[used], there[used], 0)
    if found is None:
        return None, used
    matrix = np.asarray(found, dtype=np.float64)
    return matrix / matrix[2, 2], used


def _contradiction(known: PointPairs, used: NDArray[np.bool_], outlier_px: float) -> str:
    """Say why the points make no picture."""
    _, mirrored = _robust(known.surface, known.projector * (-1.0, 1.0), outlier_px)
    if np.mean(mirrored) >= LEAST_INLIERS:
        return (
            "the projector's picture is mirrored: switch off rear projection or mirroring in its "
            "menu, and try again"
        )
    outliers = _left_out(known, used)
    named = ", ".join(outliers[:4]) + (", ..." if len(outliers) > 4 else "")
    return (
        f"{len(outliers)} of {len(used)} points contradict the others ({named}): let nothing "
        f"move or lie on the surface meanwhile, and try again"
    )


def _left_out(known: PointPairs, used: NDArray[np.bool_]) -> tuple[str, ...]:
    return tuple(name for name, good in zip(known.names, used, strict=True) if not good)


def mapped(matrix: Points, points: Points) -> Points:
    """(N, 2) points through a (3, 3) homography."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return np.asarray(mapped[:, :2] / mapped[:, 2:], dtype=np.float64)


def _require_spread(points: Points) -> None:
    if len(points) < DOF or not np.isfinite(points).all():
        raise CalibrationError(
            f"only {len(points)} points are known on the surface, and {DOF} are the least: let "
            f"the camera see more of the projector's picture"
        )
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[1] < THIN * spread[0]:
        raise CalibrationError(
            "the points lie in a line, which leaves the area next to it open: let the camera "
            "see the whole picture of the projector, and try again"
        )


def _covered(matrix: Points, known: PointPairs, seen: Points, surface: Surface) -> float:
    """Share of the surface under all that was offered, over which points were seen."""
    across, down = np.meshgrid(np.linspace(0.0, 1.0, 61), np.linspace(0.0, 1.0, 41))
    shares = np.column_stack([across.ravel(), down.ravel()])
    places = shares * (surface.width_mm, surface.height_mm)
    lit = inside(places, mapped(np.linalg.inv(matrix), known.offered))
    if np.mean(lit) < LIT:
        raise CalibrationError(
            f"the projector lights only {100.0 * np.mean(lit):.0f} % of the surface: turn or move "
            f"it until its picture lies on the surface, and try again"
        )
    return float(np.mean(inside(places[lit], seen)))
