"""The projector's pixels on the surface, from points known on both. Pure.

Rule: three ways to know points, one fit (`homography`). What the camera sees goes to the surface
along its lens's rays, so no homography of the camera is needed, and errors of the plane cancel:
touches come to the surface by the same rays.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from halo_calibration.boards.board import SQUARE, Picture, Projected, crosses
from halo_calibration.boards.detect import DetectedBoard, detect
from halo_calibration.boards.graycode import Decoded
from halo_calibration.boards.hints import require_seen
from halo_calibration.errors import CalibrationError
from halo_calibration.image_places import place
from halo_calibration.solvers.homography import HomographyFit, PointPairs, mapped, solve
from halo_calibration.solvers.rigid2d import steady
from halo_service.geometry.camera import Lens, Points
from halo_service.geometry.surface import Surface

WORST_PX, WORST_TOUCH_MM = 3.0, 4.0
"""A fit with a larger error is refused (the accuracy that the documentation states)."""
OUTLIER_PX, OUTLIER_TOUCH_MM = 6.0, 12.0
"""What lies farther from the fit takes no part: twice and three times the worst of a good fit."""
COVERED = 0.7
"""Of the part of the surface that the pattern should light, which must have been seen."""
CROSSES = tuple(
    f"{row} {column}".strip()
    for row in ("far", "middle", "near")
    for column in ("left", "", "right")
)
"""What the nine are called, where the picture's top is the far edge."""


def projector_by_markers(
    picture: Picture, board: Projected, lens: Lens, lens_from_camera: Points, surface: Surface
) -> HomographyFit:
    """Solve from one picture of the projected ChArUco board. Raises `CalibrationError`.

    `picture`: (h, w) or (h, w, 3) uint8 through `lens`; `lens_from_camera`: (4, 4) mm from the
    depth camera's frame.
    """
    seen = detect(picture, board)
    require_seen(seen, picture, board)
    return projector_of(seen, board, lens, lens_from_camera, surface)


def projector_of(
    seen: DetectedBoard, board: Projected, lens: Lens, lens_from_camera: Points, surface: Surface
) -> HomographyFit:
    """Solve from the board's points, once they were seen. Raises `CalibrationError`."""
    known = PointPairs(
        surface.seen_at(seen.picture, lens, lens_from_camera),
        seen.board,
        [f"corner {number}" for number in seen.numbers],
        board.points_px,
    )
    size = (board.width_px, board.height_px)
    solved = solve(known, size, surface, OUTLIER_PX)
    _require_close(solved.error_px, WORST_PX, "px", "let nothing move, focus the projector")
    if solved.covered < COVERED:
        back = np.linalg.inv(solved.projector.projector_from_surface)
        hidden = mapped(back, board.points_px[list(seen.missing)])
        where = place(*(hidden.mean(axis=0) / (surface.width_mm, surface.height_mm)).clip(0.0, 1.0))
        raise CalibrationError(
            f"only {100.0 * solved.covered:.0f} % of the surface under the projected board was "
            f"seen, it is hidden {where}: take away what covers it, and try again"
        )
    return solved


def projector_by_gray_code(
    decoded: Decoded, lens: Lens, lens_from_camera: Points, surface: Surface
) -> HomographyFit:
    """Solve from decoded Gray code pictures, taken through `lens`. Raises `CalibrationError`."""
    size = decoded.width_px, decoded.height_px
    known = PointPairs(
        surface.seen_at(decoded.picture, lens, lens_from_camera),
        decoded.projector,
        [f"{x:.0f}, {y:.0f}" for x, y in decoded.projector],
        SQUARE * size + np.array(size) / 2.0,
    )
    solved = solve(known, size, surface, OUTLIER_PX)
    _require_close(solved.error_px, WORST_PX, "px", "let nothing move, focus the projector")
    if solved.covered < COVERED:
        raise CalibrationError(
            f"only {100.0 * solved.covered:.0f} % of the surface in the projector's light was "
            f"seen: take away what covers it, and try again"
        )
    return solved


def projector_by_touches(
    touches: Sequence[Points], width_px: int, height_px: int, surface: Surface
) -> HomographyFit:
    """Solve from nine projected `crosses`, each touched three times. Raises `CalibrationError`.

    `touches`: nine times (N, 2) mm on the surface, in the order of `crosses`.
    """
    middles = [steady(f"the {name} cross", at) for name, at in zip(CROSSES, touches, strict=True)]
    places = crosses(width_px, height_px)
    known = PointPairs(np.array(middles), places, [f"the {name} cross" for name in CROSSES], places)
    apart_mm = max(float(np.linalg.norm(np.std(middles, axis=0))), 1.0)
    px_per_mm = float(np.linalg.norm(np.std(places, axis=0))) / apart_mm
    solved = solve(known, (width_px, height_px), surface, OUTLIER_TOUCH_MM * px_per_mm)
    again = "touch each cross in its middle, always with the same finger"
    _require_close(solved.error_mm, WORST_TOUCH_MM, "mm", again)
    return solved


def _require_close(error: float, worst: float, unit: str, remedy: str) -> None:
    if error > worst:
        raise CalibrationError(
            f"the fit is off by {error:.1f} {unit}, and {worst:.0f} are the most: {remedy}, and "
            f"try again"
        )
