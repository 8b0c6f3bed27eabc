"""Sends frames, the scene and the health on every carrier, in the same bytes."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

import halo_protocol as wire
from halo_service.app.service.carriers import Carriers
from halo_service.app.service.fit_watcher import Fit
from halo_service.app.versions import service_version
from halo_service.geometry.camera import Camera
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import OutgoingReport, Reported
from halo_service.profile import Profile, Projector
from halo_service.runtime.health import Health
from halo_service.sensing import DEFAULT_SURFACE, State
from halo_service.values import SourceKind, TouchFrame

SOURCES = {
    "camera": wire.Source.CAMERA,
    "recording": wire.Source.RECORDING,
    "virtual": wire.Source.VIRTUAL,
}
CALIBRATIONS = {
    "none": wire.Calibration.NONE,
    "partial": wire.Calibration.PARTIAL,
    "complete": wire.Calibration.COMPLETE,
}


class Publisher:
    """Sends what the live loop publishes to clients."""

    def __init__(
        self,
        frames: FrameEncoder,
        carriers: list[Carrier],
        kind: SourceKind,
        camera: Camera,
        surface: str,
        control_port: int = 0,
        names: NameWatch | None = None,
        fit: Callable[[], Fit] = lambda: "unknown",
        write_errors: Callable[[], int] = lambda: 0,
        zenoh_missing: Callable[[], int] = lambda: 0,
        zenoh_version: str = "",
    ) -> None:
        """`surface`: its name, in every address; `kind`: where the frames come from;
        `control_port`: 0 if there is none; `names`: notices other services of the same name;
        `fit`: whether the profile fits; `write_errors`: profiles that could not be saved;
        `zenoh_missing`: routers and peers without a connection; `zenoh_version`: empty without
        Zenoh."""
        self._frames = frames
        self._carriers = Carriers(carriers)
        self.kind: SourceKind = kind
        """Changes when the control page shows a recording in the camera's place."""
        self._camera = camera
        self._surface = surface
        self._control_port = control_port
        self._names = names
        self._fit = fit
        self._write_errors = write_errors
        self._zenoh_missing = zenoh_missing
        self._zenoh_version = zenoh_version

    def frame(self, frame: TouchFrame) -> None:
        """Send one frame."""
        self._carriers.send(self._frames.encode(frame))

    def scene(self, state: State) -> None:
        """Send the scene, and pose and homography if the profile has them."""
        node, session = self._frames.node, self._frames.session
        profile = state.profile
        _, width_mm, height_mm = DEFAULT_SURFACE
        revision = 0
        if profile is not None:
            width_mm, height_mm = profile.surface.width_mm, profile.surface.height_mm
            revision = profile.revision
        scene = wire.Scene(
            node,
            session,
            wire.VERSION,
            width_mm,
            height_mm,
            CALIBRATIONS[profile.calibrated if profile else "none"],
            revision,
            SOURCES[self.kind],
            float(self._camera.fps),
            self._control_port,
            collision=int(self._names is not None and self._names.collision(time.monotonic())),
            calibrated_s=_unix_s(profile.changed) if profile else 0,
            service_version=service_version(),
            zenoh_version=self._zenoh_version,
        )
        self._report(scene)
        if profile is not None:  # after the scene: they refer to its revision
            self._report(self._pose(profile))
            if profile.projector is not None:
                self._report(self._homography(profile, profile.projector))

    def health(self, current: Health) -> None:
        """Send the health of the service."""
        jumps, error_ms = CLOCK.check()
        health = wire.Health(
            self._frames.node,
            self._frames.session,
            current.fps,
            current.latency_ms,
            current.drops,
            current.bad_frames,
            wire.Tracker[current.tracker.upper()],
            wire.Camera[current.camera.upper()],
            current.tracker_ms,
            jumps,
            error_ms,
            wire.ProfileFit[self._fit().upper()],
            self._zenoh_missing(),
            self._write_errors(),
            current.memory_mb,
            wire.Load[current.load.upper()],
            current.looks_hz,
            *divmod(CLOCK.unix_us(), 1_000_000),
        )
        self._report(health)

    def _pose(self, profile: Profile) -> wire.Pose:
        frames, anchor = self._frames, profile.anchor
        return wire.Pose(
            frames.node,
            frames.session,
            profile.revision,
            _numbers(profile.surface.camera_from_surface[:3]),
            (0.0,) * 12 if anchor is None else _numbers(anchor.anchor_from_surface[:3]),
            anchored=int(anchor is not None),
        )

    def _homography(self, profile: Profile, projector: Projector) -> wire.Homography:
        return wire.Homography(
            self._frames.node,
            self._frames.session,
            profile.revision,
            projector.width_px,
            projector.height_px,
            _numbers(projector.projector_from_surface),
        )

    def _report(self, message: Reported) -> None:
        self._carriers.send(OutgoingReport(self._surface, message))


def _unix_s(date: str) -> int:
    """Return the Unix time of a step's date; 0 if it has none or an odd one."""
    try:
        return max(0, int(datetime.fromisoformat(date).timestamp()))
    except ValueError:
        return 0


def _numbers(matrix: NDArray[np.float64]) -> tuple[float, ...]:
    """Return the numbers row by row, as on the wire."""
    return tuple(float(x) for x in matrix.ravel())
