"""Finds hands in a frame: blends infrared and colour, then runs the hand model."""

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
"""Depth of a pixel without a measurement while there is no background: the height in the paper."""


class HandDetector:
    """A `runtime.Tracker`: MediaPipe on the paper's blended picture."""

    def __init__(self, camera: Camera, profile: Profile | None, settings: TrackingSettings) -> None:
        """Load the hand model; download it if it is missing (`UserError` if that fails)."""
        self._tracker = HandTracker(model_for(settings), max_hands=settings.max_hands)
        self._warp = ColourWarp(camera, _background_mm(camera, profile))

    def look(self, frame: Frame) -> Tracked:
        """Find the hands in one frame."""
        picture = blend(frame.ir, frame.colour, self._warp, frame.depth)
        return self._tracker.find(picture, frame.time_us)

    def close(self) -> None:
        """Free the model."""
        self._tracker.close()


def model_for(settings: TrackingSettings) -> Path:
    """Return the path of the hand model; `UserError` if it is missing and the download fails."""
    return hand_model(from_home(settings.model) if settings.model else None)


def _background_mm(camera: Camera, profile: Profile | None) -> NDArray[np.float32]:
    shape = (camera.depth.height, camera.depth.width)
    if profile is None:
        return np.full(shape, ASSUMED_MM, np.float32)
    valid = profile.background.valid
    return np.where(valid, profile.background.mean_mm, np.float32(ASSUMED_MM))
