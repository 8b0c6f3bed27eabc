"""Change the surface's frame on its plane: everything expressed in the old frame is transformed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halo_calibration.solvers.correction import Base, Reference, solve_correction
from halo_calibration.solvers.touch import corrected
from halo_service.geometry.surface import Surface
from halo_service.profile import Correction, Profile, Projector, TouchState, TouchStates

Matrix = NDArray[np.float64]


def moved_to(profile: Profile, surface: Surface, base: Base | None) -> Profile:
    """Return the profile with another surface on its plane.

    Places and directions of the touches and of the sweep, the projector and the anchor keep
    where they are on the table. `base`: what the correction is fitted on again, unless dropped.
    """
    old_from_new = np.linalg.inv(profile.surface.camera_from_surface) @ surface.camera_from_surface
    new_from_old = np.linalg.inv(old_from_new)
    moved = replace(
        profile,
        surface=surface,
        touch=None if profile.touch is None else _states(profile.touch, new_from_old),
        by_hand={side: _states(each, new_from_old) for side, each in profile.by_hand.items()},
        projector=None
        if profile.projector is None
        else _projector(profile.projector, _on_plane(old_from_new)),
        anchor=None
        if profile.anchor is None
        else replace(
            profile.anchor,
            anchor_from_surface=profile.anchor.anchor_from_surface @ old_from_new,
        ),
    )
    if profile.correction is None or moved.touch is None:
        return moved
    return _fitted(moved, profile.correction, base, new_from_old)


def _fitted(
    profile: Profile, correction: Correction, base: Base | None, new_from_old: Matrix
) -> Profile:
    """Fit the correction on the moved samples: its grid lies along the surface's edges."""
    assert profile.touch is not None  # the sweep needs the four states
    samples = correction.samples.astype(np.float64)
    samples[:, :2] = _places(new_from_old, samples[:, :2])
    samples[:, 3] += _turn_deg(new_from_old)
    held = profile.touch.touch
    at = Reference(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
    refitted = solve_correction(profile.surface, base, samples, at)
    return replace(
        profile,
        correction=refitted,
        touch=corrected(profile.touch, refitted),
        by_hand={side: corrected(each, refitted) for side, each in profile.by_hand.items()},
    )


def _states(states: TouchStates, new_from_old: Matrix) -> TouchStates:
    def held(state: TouchState) -> TouchState:
        ((x_mm, y_mm),) = _places(new_from_old, np.array([[state.x_mm, state.y_mm]])).tolist()
        yaw_deg = state.yaw_deg + _turn_deg(new_from_old)
        return replace(state, x_mm=x_mm, y_mm=y_mm, yaw_deg=yaw_deg)

    return states.with_each(held)


def _projector(projector: Projector, old_from_new: Matrix) -> Projector:
    matrix = projector.projector_from_surface @ old_from_new
    return replace(projector, projector_from_surface=matrix / matrix[2, 2])


def _places(new_from_old: Matrix, places: Matrix) -> Matrix:
    """(N, 2) mm."""
    return np.asarray(places @ new_from_old[:2, :2].T + new_from_old[:2, 3], dtype=np.float64)


def _on_plane(matrix: Matrix) -> Matrix:
    """(3, 3) of points with z = 0."""
    return matrix[np.ix_((0, 1, 3), (0, 1, 3))]


def _turn_deg(new_from_old: Matrix) -> float:
    """How much a direction's yaw grows: clockwise as the user sees it, as x turns to y."""
    return float(np.degrees(np.arctan2(new_from_old[1, 0], new_from_old[0, 0])))
