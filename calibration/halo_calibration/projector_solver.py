"""The projector's pixels on the surface, from points known on both. Pure.

Rule: three ways to know points, one fit, one judgement. What the camera sees goes to the surface
along its lens's rays, so no homography of the camera is needed, and errors of the plane cancel:
touches come to the surface by the same rays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.boards import Picture, Projected, crosses
from halo_calibration.errors import Refused
from halo_calibration.flat import inside, steady
from halo_calibration.graycode import Decoded
from halo_calibration.sighting import Seen, detect
from halo_calibration.unseen import require_seen
from halo_calibration.where import place
from halo_service.geometry.camera import Lens, Points
from halo_service.geometry.surface import Surface
from halo_service.profile import Projector
from halo_service.values import Pixels

WORST_PX, WORST_TOUCH_MM = 3.0, 4.0
"""A fit with a larger error is refused (the promise to the user)."""
OUTLIER_PX, OUTLIER_TOUCH_MM = 6.0, 12.0
"""What lies farther from the fit takes no part: twice and three times the worst of a good fit."""
LEAST_INLIERS = 0.7
"""Of the points: below, nobody knows which of them are right."""
THIN = 0.1
"""Width over length of a cloud of points below which they are in a line."""
COVERED = 0.7
"""Of the part of the surface that the pattern should light, which must have been seen."""
LIT = 0.1
"""Of the surface, which the pattern must light at least."""
CROSSES = tuple(
    f"{row} {column}".strip()
    for row in ("far", "middle", "near")
    for column in ("left", "", "right")
)
"""What the nine are called, where the picture's top is the far edge."""
ROUNDS = 3
"""Of least squares on those who agree; it stands still after two."""
DOF = 4
"""Points that a homography fits whatever they are."""


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
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
    outliers: tuple[str, ...]
    """Names of the points that took no part."""
    covered: float
    """Share of the surface under the pattern where points were seen."""


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """What one way of looking knows."""

    surface: Points
    """(N, 2) mm."""
    projector: Pixels
    """(N, 2) px."""
    names: Sequence[str]
    offered: Pixels
    """(M, 2) px of all points there were to be seen."""


def projector_by_markers(
    picture: Picture, board: Projected, lens: Lens, lens_from_camera: Points, surface: Surface
) -> Solved:
    """Solve from one picture of the projected ChArUco board. Raises `Refused`.

    `picture`: (h, w) or (h, w, 3) uint8 through `lens`; `lens_from_camera`: (4, 4) mm from the
    depth camera's frame.
    """
    seen = detect(picture, board)
    require_seen(seen, picture, board)
    return projector_of(seen, board, lens, lens_from_camera, surface)


def projector_of(
    seen: Seen, board: Projected, lens: Lens, lens_from_camera: Points, surface: Surface
) -> Solved:
    """Solve from the board's points, once they were seen. Raises `Refused`."""
    known = _Points(
        surface.seen_at(seen.picture, lens, lens_from_camera),
        seen.board,
        [f"corner {number}" for number in seen.numbers],
        board.points_px,
    )
    size = (board.width_px, board.height_px)
    solved = _solve(known, size, surface, OUTLIER_PX)
    _require_close(solved.error_px, WORST_PX, "px", "let nothing move, focus the projector")
    if solved.covered < COVERED:
        back = np.linalg.inv(solved.projector.projector_from_surface)
        hidden = _mapped(back, board.points_px[list(seen.missing)])
        where = place(*(hidden.mean(axis=0) / (surface.width_mm, surface.height_mm)).clip(0.0, 1.0))
        raise Refused(
            f"only {100.0 * solved.covered:.0f} % of the surface under the projected board was "
            f"seen, it is hidden {where}: take away what covers it, and try again"
        )
    return solved


def projector_by_gray_code(
    decoded: Decoded, lens: Lens, lens_from_camera: Points, surface: Surface
) -> Solved:
    """Solve from decoded Gray code pictures, taken through `lens`. Raises `Refused`."""
    size = decoded.width_px, decoded.height_px
    known = _Points(
        surface.seen_at(decoded.picture, lens, lens_from_camera),
        decoded.projector,
        [f"{x:.0f}, {y:.0f}" for x, y in decoded.projector],
        _corners(*size),
    )
    solved = _solve(known, size, surface, OUTLIER_PX)
    _require_close(solved.error_px, WORST_PX, "px", "let nothing move, focus the projector")
    if solved.covered < COVERED:
        raise Refused(
            f"only {100.0 * solved.covered:.0f} % of the surface in the projector's light was "
            f"seen: take away what covers it, and try again"
        )
    return solved


def projector_by_touches(
    touches: Sequence[Points], width_px: int, height_px: int, surface: Surface
) -> Solved:
    """Solve from nine projected `crosses`, each touched three times. Raises `Refused`.

    `touches`: nine times (N, 2) mm on the surface, in the order of `crosses`.
    """
    middles = [steady(f"the {name} cross", at) for name, at in zip(CROSSES, touches, strict=True)]
    places = crosses(width_px, height_px)
    known = _Points(np.array(middles), places, [f"the {name} cross" for name in CROSSES], places)
    apart_mm = max(float(np.linalg.norm(np.std(middles, axis=0))), 1.0)
    px_per_mm = float(np.linalg.norm(np.std(places, axis=0))) / apart_mm
    solved = _solve(known, (width_px, height_px), surface, OUTLIER_TOUCH_MM * px_per_mm)
    again = "touch each cross in its middle, always with the same finger"
    _require_close(solved.error_mm, WORST_TOUCH_MM, "mm", again)
    return solved


def _solve(known: _Points, size: tuple[int, int], surface: Surface, outlier_px: float) -> Solved:
    here, there = known.surface, known.projector
    _require_spread(here)
    _require_spread(there)
    matrix, used = _robust(here, there, outlier_px)
    if matrix is None or np.mean(used) < LEAST_INLIERS:
        raise Refused(_contradiction(known, used, outlier_px))
    _require_spread(here[used])
    off_px = np.linalg.norm(_mapped(matrix, here) - there, axis=1)
    off_mm = np.linalg.norm(_mapped(np.linalg.inv(matrix), there) - here, axis=1)
    free = max(int(np.count_nonzero(used)) - DOF, 1)
    return Solved(
        Projector(size[0], size[1], matrix),
        error_px=float(np.sqrt(np.sum(off_px[used] ** 2) / free)),
        error_mm=float(np.sqrt(np.sum(off_mm[used] ** 2) / free)),
        off_px=off_px,
        off_mm=off_mm,
        outliers=_left_out(known, used),
        covered=_covered(matrix, known, here[used], surface),
    )


def _robust(
    here: Points, there: Pixels, outlier_px: float
) -> tuple[Points | None, NDArray[np.bool_]]:
    """(3, 3) homography with last element 1, and which of the points it stands on."""
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
        off = _mapped(np.asarray(found, dtype=np.float64), here) - there
        used = np.linalg.norm(off, axis=1) < outlier_px
        if np.count_nonzero(used) < DOF:
            return None, used
        found, _ = cv2.findHomography(here[used], there[used], 0)
    if found is None:
        return None, used
    matrix = np.asarray(found, dtype=np.float64)
    return matrix / matrix[2, 2], used


def _contradiction(known: _Points, used: NDArray[np.bool_], outlier_px: float) -> str:
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


def _left_out(known: _Points, used: NDArray[np.bool_]) -> tuple[str, ...]:
    return tuple(name for name, good in zip(known.names, used, strict=True) if not good)


def _mapped(matrix: Points, points: Points) -> Points:
    mapped = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return np.asarray(mapped[:, :2] / mapped[:, 2:], dtype=np.float64)


def _require_spread(points: Points) -> None:
    if len(points) < DOF or not np.isfinite(points).all():
        raise Refused(
            f"only {len(points)} points are known on the surface, and {DOF} are the least: let "
            f"the camera see more of the projector's picture"
        )
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[1] < THIN * spread[0]:
        raise Refused(
            "the points lie in a line, which says nothing of what is beside it: let the camera "
            "see the whole picture of the projector, and try again"
        )


def _require_close(error: float, worst: float, unit: str, remedy: str) -> None:
    if error > worst:
        raise Refused(
            f"the fit is off by {error:.1f} {unit}, and {worst:.0f} are the most: {remedy}, and "
            f"try again"
        )


def _covered(matrix: Points, known: _Points, seen: Points, surface: Surface) -> float:
    """Share of the surface under all that was offered, over which points were seen."""
    across, down = np.meshgrid(np.linspace(0.0, 1.0, 61), np.linspace(0.0, 1.0, 41))
    shares = np.column_stack([across.ravel(), down.ravel()])
    places = shares * (surface.width_mm, surface.height_mm)
    lit = inside(places, _mapped(np.linalg.inv(matrix), known.offered))
    if np.mean(lit) < LIT:
        raise Refused(
            f"the projector lights only {100.0 * np.mean(lit):.0f} % of the surface: turn or move "
            f"it until its picture lies on the surface, and try again"
        )
    return float(np.mean(inside(places[lit], seen)))


def _corners(width: float, height: float) -> Points:
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
