"""The steps for places: surface, projector, anchor.

Rule: as `steps`: what was seen becomes a change of the profile; no prompts, no frames fetched.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from halo_calibration.boards.board import Picture, Printed, Projected
from halo_calibration.boards.graycode import decode
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.anchor import anchor_pose
from halo_calibration.solvers.change_surface import moved_to
from halo_calibration.solvers.dwell import Place
from halo_calibration.solvers.homography import HomographyFit
from halo_calibration.solvers.projector import (
    projector_by_gray_code,
    projector_by_markers,
    projector_by_touches,
)
from halo_calibration.solvers.rigid2d import TOUCHES
from halo_calibration.solvers.surface import (
    CORNERS,
    SurfaceFit,
    surface_by_markers,
    surface_by_touches,
)
from halo_calibration.steps import Change, Setup, require, rounded
from halo_service.geometry.camera import Camera, Lens, Points
from halo_service.hand_tracking.blend import toned
from halo_service.profile import Profile, StepRecord
from halo_service.profile.model import Quality
from halo_service.values import Frame

GOOD_SHEET_MM, GOOD_CORNERS_MM = 0.7, 3.0
"""Beyond these a surface is rated fair: half of the limit for refusal."""
GOOD_PX, GOOD_CROSSES_MM = 1.5, 2.5
"""Likewise for a projector."""
GOOD_ANCHOR_MM = 0.7
"""Likewise for an anchor."""
MOST_NAMED = 6
"""Points that are named one by one."""
MOST_LOGGED = 100
"""The worst points are logged with their error: stripes have thousands of points."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A picture of the table, and the lens that it came through."""

    picture: Picture
    """(h, w, 3) BGR in colour, (h, w) in infrared."""
    lens: Lens
    lens_from_camera: Points
    """(4, 4), mm."""


def colour_view(frames: Iterable[Frame], camera: Camera) -> View:
    """Average the colour of frames of a still table. Raises `CalibrationError` without colour."""
    colours = [each for each in (_decoded(frame) for frame in frames) if each is not None]
    if camera.colour is None or not colours:
        raise CalibrationError(
            "the camera gives no colour picture, and the projector's light is in no other: record "
            "with colour, or calibrate the projector by touch"
        )
    return View(_mean(colours), camera.colour, camera.colour_from_depth)


def sheet_view(frames: Sequence[Frame], camera: Camera) -> View:
    """Average frames of something printed: in colour where there is any, else in infrared."""
    if camera.colour is not None and any(frame.colour is not None for frame in frames):
        return colour_view(frames, camera)
    return View(_mean([toned(frame.ir) for frame in frames]), camera.depth, np.eye(4))


def sheet_change(
    setup: Setup,
    frames: Sequence[Frame],
    profile: Profile,
    width_mm: float = 300.0,
    height_mm: float = 200.0,
) -> Change:
    """Lay the surface around the printed sheet. Raises `CalibrationError`."""
    view = sheet_view(frames, setup.camera)
    fit = surface_by_markers(
        view.picture, view.lens, view.lens_from_camera, profile.surface, width_mm, height_mm
    )
    figures = rounded(error_mm=fit.error_mm, error_px=fit.error_px, print_scale=fit.scale)
    return _surface_fit_change(setup, fit, figures, GOOD_SHEET_MM)


def corners_change(setup: Setup, touches: Sequence[Sequence[Place]], profile: Profile) -> Change:
    """Lay the surface between four touched corners, far left first, clockwise.

    `touches`: in the frame of the profile's surface. Raises `CalibrationError`.
    """
    fit = surface_by_touches([np.array(each) for each in touches], profile.surface)
    return _surface_fit_change(setup, fit, rounded(error_mm=fit.error_mm), GOOD_CORNERS_MM)


def dragged_change(setup: Setup, corners_px: Points, profile: Profile) -> Change:
    """Lay the surface between four corners in the depth picture, far left first, clockwise.

    `corners_px`: (4, 2). Raises `CalibrationError`.
    """
    if corners_px.shape != (len(CORNERS), 2) or not np.isfinite(corners_px).all():
        raise CalibrationError("the surface needs four corners in the picture")
    corners = profile.surface.seen_at(corners_px, setup.camera.depth, np.eye(4))
    if not np.isfinite(corners).all():
        raise CalibrationError("a corner is where the camera does not see the table: move it")
    # A corner in a picture is exact: it needs no repetition, as touches do.
    fit = surface_by_touches([np.tile(corner, (TOUCHES, 1)) for corner in corners], profile.surface)
    return _surface_fit_change(setup, fit, rounded(error_mm=fit.error_mm), GOOD_CORNERS_MM)


def board_change(
    setup: Setup, frames: Iterable[Frame], profile: Profile, board: Projected
) -> Change:
    """Calibrate the projector from its board, seen in colour. Raises `CalibrationError`."""
    view = colour_view(frames, setup.camera)
    solved = projector_by_markers(
        view.picture, board, view.lens, view.lens_from_camera, profile.surface
    )
    return _projector_change(setup, solved, solved.error_px < GOOD_PX)


def stripes_change(
    setup: Setup,
    views: Sequence[View],
    profile: Profile,
    size_px: tuple[int, int],
) -> Change:
    """Calibrate the projector from Gray code: a view of each picture, in the pictures' order.

    Raises `CalibrationError`.
    """
    decoded = decode([view.picture for view in views], *size_px)
    solved = projector_by_gray_code(
        decoded, views[0].lens, views[0].lens_from_camera, profile.surface
    )
    return _projector_change(setup, solved, solved.error_px < GOOD_PX)


def crosses_change(
    setup: Setup,
    touches: Sequence[Sequence[Place]],
    profile: Profile,
    size_px: tuple[int, int],
) -> Change:
    """Calibrate the projector from its nine touched crosses. Raises `CalibrationError`."""
    solved = projector_by_touches([np.array(each) for each in touches], *size_px, profile.surface)
    return _projector_change(setup, solved, solved.error_mm < GOOD_CROSSES_MM)


def anchor_change(
    setup: Setup, frames: Sequence[Frame], profile: Profile, marker: Printed
) -> Change:
    """Calibrate the pose of a printed marker. Raises `CalibrationError`."""
    view = colour_view(frames, setup.camera)
    depths = [frame.depth for frame in frames]
    found = anchor_pose(
        view.picture, marker, setup.camera, profile.surface, profile.background, depths
    )
    record = StepRecord(
        setup.date,
        "good" if found.error_mm < GOOD_ANCHOR_MM else "fair",
        rounded(
            error_mm=found.error_mm,
            print_scale=found.scale,
            height_mm=0.0 if found.lies else found.height_mm,
            tilt_deg=0.0 if found.lies else found.tilt_deg,
        ),
        "it lies on the surface" if found.lies else "it is above the surface",
    )

    def change(before: Profile | None) -> Profile:
        known = require(before, "anchor")
        return replace(known, anchor=found.anchor, steps={**known.steps, "anchor": record})

    return change


def _surface_fit_change(
    setup: Setup, fit: SurfaceFit, figures: dict[str, float], good_mm: float
) -> Change:
    quality: Quality = "good" if fit.error_mm < good_mm else "fair"
    size = rounded(width_mm=fit.surface.width_mm, height_mm=fit.surface.height_mm)
    record = StepRecord(setup.date, quality, {**figures, **size})

    def change(before: Profile | None) -> Profile:
        known = require(before, "surface")
        return replace(
            moved_to(known, fit.surface, setup.base), steps={**known.steps, "surface": record}
        )

    return change


def _projector_change(setup: Setup, solved: HomographyFit, good: bool) -> Change:
    for point in np.argsort(-solved.off_mm, kind="stable")[:MOST_LOGGED]:
        name, off_px, off_mm = solved.names[point], solved.off_px[point], solved.off_mm[point]
        _log.debug("%s: off by %.2f px, %.2f mm", name, off_px, off_mm)
    left_out = ", ".join(solved.outliers[:MOST_NAMED])
    more = len(solved.outliers) - MOST_NAMED
    record = StepRecord(
        setup.date,
        "good" if good else "fair",
        rounded(
            error_px=solved.error_px,
            error_mm=solved.error_mm,
            points=len(solved.off_px),
            worst_mm=float(np.max(solved.off_mm)),
            covered_share=solved.covered,
        ),
        f"left out: {left_out}{f' and {more} more' if more > 0 else ''}" if left_out else "",
    )

    def change(before: Profile | None) -> Profile:
        known = require(before, "projector")
        steps = {**known.steps, "projector": record}
        return replace(known, projector=solved.projector, steps=steps)

    return change


def _decoded(frame: Frame) -> Picture | None:
    if not isinstance(frame.colour, bytes):
        return frame.colour
    picture = cv2.imdecode(np.frombuffer(frame.colour, np.uint8), cv2.IMREAD_COLOR)
    return None if picture is None else np.asarray(picture, dtype=np.uint8)


def _mean(pictures: Sequence[Picture]) -> Picture:
    total = np.zeros(pictures[0].shape, np.float32)
    for picture in pictures:
        cv2.accumulate(picture, total)
    return np.asarray(np.rint(total / len(pictures)), dtype=np.uint8)
