"""The hand tracker's way of looking at a frame: blend infrared and colour, then find hands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halo_service.files import from_home
from halo_service.geometry.camera import Camera
from halo_service.hand_tracking.blend import ColourWarp, blend
from halo_service.hand_tracking.hands import HandTracker
from halo_service.hand_tracking.model import hand_model
from halo_service.profile import Profile
from halo_service.settings import TrackingSettings
from halo_service.values import Frame, Tracked

ASSUMED_MM = 500.0
"""Where a pixel without depth is taken to be while no background is known: the paper's height."""


class HandDetector:
    """A `runtime.Tracker`: MediaPipe on the paper's blended picture."""

    def __init__(self, camera: Camera, profile: Profile | None, settings: TrackingSettings) -> None:
        """Load the model, fetching it where it is not there yet (`UserError` where it can't be)."""
        self._tracker = HandTracker(model_for(settings), max_hands=settings.max_hands)
        self._warp = ColourWarp(camera, _background_mm(camera, profile))

    def look(self, frame: Frame) -> Tracked:
        """Find the hands in one frame."""
        picture = blend(frame.ir, frame.colour, self._warp, frame.depth)
        return self._tracker.find(picture, frame.time_us)

    def close(self) -> None:
        """Let the model go."""
        self._tracker.close()


def model_for(settings: TrackingSettings) -> Path:
    """Return the hand model's path; `UserError` where there is none and none can be fetched."""
    return hand_model(from_home(settings.model) if settings.model else None)


def _background_mm(camera: Camera, profile: Profile | None) -> NDArray[np.float32]:
    shape = (camera.depth.height, camera.depth.width)
    if profile is None:
        return np.full(shape, ASSUMED_MM, np.float32)
    known = profile.background.valid
    return np.where(known, profile.background.mean_mm, np.float32(ASSUMED_MM))
