"""The frames of a session, each sensed as the service does it: what the report compares."""

from __future__ import annotations

from collections.abc import Iterator

from halo_calibration.observe import DetectHands, Observation, Observer
from halo_calibration.steps.session import Session
from halo_service.profile import Profile
from halo_service.runtime.checks import check_capture
from halo_service.runtime.method import OURS
from halo_service.sensing import start
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.values import Frame, TouchFrame, Tracked

WHOLE_SESSION_S = 1e6


class Sensed:
    """The frames of a source, each sensed as the service does it while the session runs."""

    def __init__(
        self, source: Source, profile: Profile, detect: DetectHands, settings: Settings
    ) -> None:
        """`detect`: the hand tracker; its hands come one frame late, as they do live."""
        self._source = source
        self._detect = detect
        self._tracked: Tracked | None = None
        self._state = start(profile, settings.sensing)
        self._observer = Observer(profile, self._latest, settings.sensing)
        self._came = self._lost = 0
        self.published: list[TouchFrame] = []

    def frames(self) -> Iterator[Frame]:
        """Yield the good frames, and sense each."""
        last_us: int | None = None
        for frame in Session(self._source).lasting(WHOLE_SESSION_S, "first light"):
            self._lost += check_capture(frame, last_us, self._source.camera.fps).missed
            self._came += 1
            last_us = frame.time_us
            touch_frame, self._state = OURS.step(self._state, frame, self._tracked)
            self.published.append(touch_frame)
            self._tracked = self._detect(frame)
            yield frame

    def see(self, frame: Frame) -> Observation | None:
        """Return the index finger in the newest frame."""
        return self._observer.see(frame)

    @property
    def lost_share(self) -> float:
        """Share of the frames that never came."""
        return self._lost / max(self._came + self._lost, 1)

    def _latest(self, frame: Frame) -> Tracked:
        return self._tracked or Tracked(frame.time_us, ())
