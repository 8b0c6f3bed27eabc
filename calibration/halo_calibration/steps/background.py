"""The steps that need no finger: the empty surface, and the frame that the view alone gives it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from halo_calibration.errors import CalibrationError
from halo_calibration.observe import DetectHands
from halo_calibration.solvers.background import halo_threshold, solve_background
from halo_calibration.solvers.change_surface import moved_to
from halo_calibration.solvers.plane import Plane, solve_plane, surface_from_view
from halo_calibration.solvers.surface import check_size
from halo_calibration.steps.change import Change, Setup, require, rounded
from halo_service.profile import Profile, StepRecord
from halo_service.values import Frame

BY_BACKGROUND = "placed by the background step, in the middle of the picture"
"""Note of a surface that no step of its own has placed."""
SAME_MM, SAME_DEG = 3.0, 0.5
"""If the plane of a new background agrees this well, the surface stays where it was."""
HANDS_LOOKED_FOR = 10
"""Every tenth frame of the background is searched for hands."""
FAIR_RESIDUAL_MM, FAIR_LEFT_OUT = 3.0, 0.25
"""Beyond these the plane is rated fair: the sensor's own unevenness is 1 to 2 mm."""


def background_change(setup: Setup, frames: Sequence[Frame], detect: DetectHands) -> Change:
    """Calibrate the empty surface, and the plane it lies in. Raises `CalibrationError`."""
    background = solve_background([frame.depth for frame in frames], [frame.ir for frame in frames])
    _refuse_hands(frames, detect)
    plane = solve_plane(background, setup.camera)
    noise_mm = float(np.median(background.noise_mm[background.valid]))
    share = float(np.mean(background.valid))
    record = StepRecord(
        setup.date,
        "good",
        rounded(frames=len(frames), noise_mm=noise_mm, measured_share=share),
    )

    def change(before: Profile | None) -> Profile:
        surface = surface_from_view(plane)
        steps = {} if before is None else dict(before.steps)
        steps["background"] = record
        if before is None:
            fresh = Profile(setup.name, setup.camera, surface, background, None, 1)
        elif _agrees(before, plane):
            fresh = replace(before, background=background)
        else:
            # What was calibrated on another plane is no longer valid.
            fresh = replace(
                before, surface=surface, background=background, touch=None, by_hand={},
                correction=None, projector=None, anchor=None,
            )  # fmt: skip
            steps = {"background": record}
        steps.setdefault("surface", _surface_record(setup, plane, BY_BACKGROUND))
        return replace(fresh, halo_threshold_mm=halo_threshold(background), steps=steps)

    return change


def surface_change(setup: Setup, width_mm: float = 300.0, height_mm: float = 200.0) -> Change:
    """Reset the surface's frame, from the background that the profile has.

    Raises `CalibrationError` for a size that no surface has.
    """
    check_size(width_mm, height_mm)

    def change(before: Profile | None) -> Profile:
        known = require(before, "surface")
        plane = solve_plane(known.background, setup.camera)
        return replace(
            moved_to(known, surface_from_view(plane, width_mm, height_mm), setup.base),
            steps={**known.steps, "surface": _surface_record(setup, plane)},
        )

    return change


def _refuse_hands(frames: Sequence[Frame], detect: DetectHands) -> None:
    looked = frames[::HANDS_LOOKED_FOR]
    found = sum(bool(detect(frame).hands) for frame in looked)
    if found >= max(2, len(looked) // 3):
        raise CalibrationError(
            "a hand was in the camera's view while the background was recorded: remove it, and "
            "record the background again"
        )


def _agrees(before: Profile, plane: Plane) -> bool:
    normal = before.surface.camera_from_surface[:3, 2]
    origin = before.surface.camera_from_surface[:3, 3]
    distance_mm = float(normal @ origin / normal[2])
    turned = float(np.degrees(np.arccos(np.clip(normal @ np.array(plane.normal), -1.0, 1.0))))
    return abs(distance_mm - plane.distance_mm) < SAME_MM and turned < SAME_DEG


def _surface_record(setup: Setup, plane: Plane, note: str = "") -> StepRecord:
    good = plane.residual_mm < FAIR_RESIDUAL_MM and plane.left_out < FAIR_LEFT_OUT
    return StepRecord(
        setup.date,
        "good" if good else "fair",
        rounded(
            residual_mm=plane.residual_mm,
            left_out_share=plane.left_out,
            distance_mm=plane.distance_mm,
            tilt_deg=plane.tilt_deg,
        ),
        "; ".join(each for each in (note, plane.note) if each),
    )
