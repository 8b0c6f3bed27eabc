"""How the service finds hands: in regions above a known surface, else in the whole image."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Protocol, TypeGuard

import numpy as np

from halo_service.files import from_home
from halo_service.geometry.camera import Camera
from halo_service.hand_tracking.blend import ColourWarp, blend
from halo_service.hand_tracking.model import hand_model
from halo_service.profile import Profile
from halo_service.runtime.pace import paced_by_depth
from halo_service.settings import TrackingSettings
from halo_service.values import Frame, Tracked

ASSUMED_MM = 500.0
"""Depth of a pixel without a measurement while no background is known: the paper's height."""


class _Tracker(Protocol):
    def detect(self, frame: Frame) -> Tracked: ...

    def close(self) -> None: ...


class HandDetector:
    """A `runtime.Tracker` on MediaPipe's hand model."""

    def __init__(
        self,
        camera: Camera,
        profile: Profile | None,
        settings: TrackingSettings,
        *,
        paced: bool = False,
    ) -> None:
        """Load the model; `UserError` where there is none and none can be fetched.

        `profile`: its background shows what is above the surface. None, before any calibration:
        hands are sought in the whole image. `paced`: leave out frames in which depth confirms the
        hands; the hands of such a frame are older than it.
        """
        self._tracker = _tracker(camera, profile, model_for(settings), settings.max_hands)
        self.looks = 0
        """How many images the model has got."""
        self._detect: Callable[[Frame], Tracked] = self._look
        if paced and _has_background(profile):
            self._detect = paced_by_depth(self._detect, profile, settings.max_hands)

    def detect(self, frame: Frame) -> Tracked:
        """Find the hands in one frame."""
        return self._detect(frame)

    def _look(self, frame: Frame) -> Tracked:
        self.looks += 1
        return self._tracker.detect(frame)

    def close(self) -> None:
        """Release the model."""
        self._tracker.close()


class _WholeImage:
    """The paper's way: the model on the blend of infrared and colour."""

    def __init__(self, camera: Camera, model: Path, max_hands: int) -> None:
        shape = (camera.depth.height, camera.depth.width)
        from halo_service.hand_tracking.hands import HandTracker  # costs half a second to import

        self._tracker = HandTracker(model, max_hands=max_hands)
        self._warp = ColourWarp(camera, np.full(shape, ASSUMED_MM, np.float32))

    def detect(self, frame: Frame) -> Tracked:
        picture = blend(frame.ir, frame.colour, self._warp, frame.depth)
        return self._tracker.find(picture, frame.time_us)

    def close(self) -> None:
        self._tracker.close()


def model_for(settings: TrackingSettings) -> Path:
    """Return the hand model's path; `UserError` where there is none and none can be fetched."""
    return hand_model(from_home(settings.model) if settings.model else None)


def _has_background(profile: Profile | None) -> TypeGuard[Profile]:
    return profile is not None and bool(profile.background.valid.any())


def _tracker(camera: Camera, profile: Profile | None, model: Path, max_hands: int) -> _Tracker:
    if not _has_background(profile):
        return _WholeImage(camera, model, max_hands)
    from halo_service.hand_tracking.region_tracker import RegionTracker  # likewise

    background = profile.background
    return RegionTracker(model, background.mean_mm, background.valid, camera.depth.fx, max_hands)
