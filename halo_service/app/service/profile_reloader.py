"""Updates the profile of the running service: reloads it when its file changes, changes to another
one and measures a new background on request.

Rule: a thread of its own reads, averages and saves; the live loop gets a complete profile between
two frames.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from halo_calibration.solvers.background import WANTED_FRAMES
from halo_calibration.steps import Change, Setup, background_change
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.profile.store import TEXT, amend, load, require_fit
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.latest import Latest
from halo_service.sensing import DEFAULT_SURFACE, State, adopt
from halo_service.values import Frame, Tracked

log = logging.getLogger(__name__)

LOOK_S = 0.5
"""Time between two looks at the profile on disk."""


class ProfileReloader:
    """Holds one profile while the service runs."""

    def __init__(self, folder: Path | None, camera: Camera, profile: Profile | None) -> None:
        """`folder`: where the profile is; None for a profile in memory alone."""
        self._folder = folder
        self._camera = camera
        self._profile = profile
        self._surface = profile.surface.name if profile else DEFAULT_SURFACE[0]
        self.on_change: Callable[[], None] = lambda: None
        """Called by `refresh` when there is another profile."""
        self.error = ""
        """Why the last change to another profile failed; empty: it did not."""
        self.write_errors = 0
        """Profiles that could not be saved."""
        self._wanted: Latest[Path] = Latest()
        self._stamp = self._stamp_now()
        self._collected: list[Frame] | None = None
        self._ready: Latest[list[Frame]] = Latest()
        self._new: Latest[Profile] = Latest()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="profile", daemon=True)
        self._thread.start()

    @property
    def profile(self) -> Profile | None:
        """The newest one."""
        return self._profile

    def switch(self, folder: Path) -> None:
        """Change to another profile within a second; `error` says why it failed."""
        self.error = ""
        self._wanted.put(folder)

    def retake_background(self) -> None:
        """Measure the background from the next frames. Raises `UserError` without a profile."""
        if self._profile is None:
            raise UserError("there is no profile yet: run 'halo calibrate' first")
        if self._collected is None:
            log.info("background: measuring a new one; keep hands away for two seconds")
            self._collected = []

    def watch(self, frame: Frame) -> None:
        """Collect a frame while a background is measured; fast."""
        if self._collected is None:
            return
        self._collected.append(frame)
        if len(self._collected) == WANTED_FRAMES:
            self._ready.put(self._collected)
            self._collected = None

    def refresh(self, state: State) -> State:
        """Return the state with the newest profile."""
        if self._collected is not None and any(finger.pointer for finger in state.fingers):
            log.warning("background: not measured, a hand is in view; remove it and try again")
            self._collected = None
        profile = self._new.take(0.0)
        if profile is None:
            return state
        self.on_change()
        return adopt(state, profile)

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        errors = ErrorLog()
        while not self._ended.is_set():
            frames = self._ready.take(LOOK_S)
            try:
                with errors.guard("profile"):
                    if frames is not None:
                        self._save_background(frames)
                    self._switch()
                    self._reload()
            except UserError as error:
                log.warning("%s; the service goes on with the profile it has", error)

    def _save_background(self, frames: list[Frame]) -> None:
        assert self._profile is not None  # `retake_background` checked it
        date = datetime.now(UTC).replace(microsecond=0, tzinfo=None).isoformat() + "Z"
        setup = Setup(self._profile.name, self._camera, date)
        change = background_change(setup, frames, _no_hands)
        self._profile = self._changed(change)
        self._stamp = self._stamp_now()
        self._new.put(self._profile)
        log.info("background: new, revision %d", self._profile.revision)

    def _changed(self, change: Change) -> Profile:
        if self._folder is not None:
            try:
                return amend(self._folder, change)
            except (UserError, OSError):
                self.write_errors += 1
                raise
        assert self._profile is not None
        return replace(change(self._profile), revision=self._profile.revision + 1)

    def _switch(self) -> None:
        folder = self._wanted.take(0.0)
        if folder is None:
            return
        try:
            profile = self._load(folder)
        except UserError as error:
            self.error = str(error)
            raise
        self._folder = folder
        self._stamp = self._stamp_now()
        self._use(profile)
        log.info("profile: changed to '%s', revision %d", profile.name, profile.revision)

    def _reload(self) -> None:
        stamp = self._stamp_now()
        if stamp == self._stamp or stamp is None or self._folder is None:
            return
        self._stamp = stamp
        profile = self._load(self._folder)
        self._use(profile)
        log.info("profile: '%s' changed, now revision %d", profile.name, profile.revision)

    def _load(self, folder: Path) -> Profile:
        """Load a profile. Raises `UserError` for one that this service cannot use."""
        profile = load(folder)
        require_fit(profile, self._camera)
        if profile.surface.name != self._surface:
            raise UserError(
                f"the profile '{profile.name}' has the surface '{profile.surface.name}', and this "
                f"service sends '{self._surface}'; start it again with --profile"
            )
        return profile

    def _use(self, profile: Profile) -> None:
        self._profile = profile
        self._new.put(profile)

    def _stamp_now(self) -> tuple[int, int, int] | None:
        """Return what differs between two versions of the file; None if there is no file."""
        if self._folder is None:
            return None
        try:
            stat = (self._folder / TEXT).stat()
        except OSError:
            return None  # moved away: use the loaded one until there is another
        return stat.st_mtime_ns, stat.st_size, stat.st_ino


def _no_hands(frame: Frame) -> Tracked:
    """Return no hands: `refresh` stops the measurement while there is a pointer."""
    return Tracked(frame.time_us, ())
