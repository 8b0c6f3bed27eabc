"""Checks all the time whether the profile still fits what the camera shows, and says so.

Rule: a thread of its own looks at a frame a second; the live loop only hands it over. The judge
is pure: frames and profile in, the state out.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Literal

import cv2
import numpy as np

from halo_calibration.boards.board import Picture, anchor
from halo_calibration.boards.detect import detect
from halo_service.geometry.camera import Camera, Points
from halo_service.profile import Anchor, Profile
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.latest import Latest
from halo_service.sensing.fit import MOVED_MM, surface_fit
from halo_service.values import Depth, Frame, Tracked

log = logging.getLogger(__name__)

Fit = Literal["unknown", "good", "moved", "tilted", "hidden", "marker"]

CHECK_US = 1_000_000
"""Time between two checks."""
MARKER_EVERY = 5
"""So many checks make one of the marker, which costs 40 ms."""
IN_A_ROW = 3
"""Checks that must agree: a person who leans over the table is no other table."""
HIDDEN_IN_A_ROW = 10
MARKER_MM = 5.0
"""A marker that moved by less may have been seen inaccurately."""
REMEDY = "run 'halo calibrate background' with this profile, or send /halo/1/control/background"


class FitJudge:
    """Turns single checks into a state that does not flicker."""

    def __init__(self) -> None:
        self._profile: Profile | None = None
        self._start()

    def _start(self) -> None:
        self.fit: Fit = "unknown"
        self.reason = ""
        """What is wrong and what to do; empty: nothing."""
        self._seen: Fit = "unknown"
        self._count = 0

    def see(self, profile: Profile, depth: Depth, picture: Picture | None) -> bool:
        """Check one frame; return whether the state changed. `picture`: where the marker is due."""
        if profile is not self._profile:
            self._profile = profile
            self._start()
        seen, reason = _check(profile, depth, picture)
        self._count = self._count + 1 if seen == self._seen else 1
        self._seen = seen
        needed = HIDDEN_IN_A_ROW if seen == "hidden" else IN_A_ROW
        if seen == self.fit or self._count < needed:
            return False
        self.fit, self.reason = seen, reason
        return True


class FitWatcher:
    """Watches the frames of the running service."""

    def __init__(self, profile: Callable[[], Profile | None]) -> None:
        """`profile` returns the newest one."""
        self._profile = profile
        self._judge = FitJudge()
        self._frames: Latest[Frame] = Latest()
        self._checked_us: int | None = None
        self._checks = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="profile fit", daemon=True)
        self._thread.start()

    @property
    def fit(self) -> Fit:
        """The state, as in `health`."""
        return self._judge.fit

    def watch(self, frame: Frame) -> None:
        """Hand over a frame where one is due; fast."""
        if self._checked_us is None or abs(frame.time_us - self._checked_us) >= CHECK_US:
            self._checked_us = frame.time_us
            self._frames.put(frame)

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        errors = ErrorLog()
        while not self._ended.is_set():
            frame, profile = self._frames.take(0.2), self._profile()
            if frame is None or profile is None:
                continue
            with errors.guard("profile fit"):
                self._check(frame, profile)

    def _check(self, frame: Frame, profile: Profile) -> None:
        due = profile.anchor is not None and self._checks % MARKER_EVERY == 0
        self._checks += 1
        before = self._judge.fit
        if not self._judge.see(profile, frame.depth, _picture(frame) if due else None):
            return
        if self._judge.reason:
            log.warning("profile: '%s' does not fit: %s", profile.name, self._judge.reason)
        elif before != "unknown":
            log.warning("profile: '%s' fits again", profile.name)


def watched(detect: Callable[[Frame], Tracked], profile: Profile) -> Callable[[Frame], Tracked]:
    """Return a hand tracker that also warns once if the profile does not fit a recording."""
    judge, checked_us = FitJudge(), None

    def detect_and_check(frame: Frame) -> Tracked:
        nonlocal checked_us
        due = checked_us is None or frame.time_us - checked_us >= CHECK_US
        if due and not judge.reason:
            checked_us = frame.time_us
            if judge.see(profile, frame.depth, None) and judge.reason:
                log.warning("profile: '%s' does not fit: %s", profile.name, judge.reason)
        return detect(frame)

    return detect_and_check


def _check(profile: Profile, depth: Depth, picture: Picture | None) -> tuple[Fit, str]:
    """Return what one frame shows, and the sentence for the user."""
    surface = surface_fit(depth, profile)
    if not surface.recognised:
        return "hidden", (
            "most of the calibrated background is not there; remove what covers the surface, "
            f"choose the profile of this place, or {REMEDY}"
        )
    if not surface.good:
        what = f"{surface.moved_mm:+.0f} mm away and tilted by {surface.tilted_deg:.1f} degrees"
        fit: Fit = "moved" if abs(surface.moved_mm) >= MOVED_MM else "tilted"
        return fit, f"the surface is {what} since the calibration; put it back, or {REMEDY}"
    off_mm = None if picture is None else marker_off_mm(profile, picture)
    if off_mm is not None and off_mm > MARKER_MM:
        return "marker", (
            f"the printed marker is {off_mm:.0f} mm from its place; put it back, or run "
            "'halo calibrate anchor' with this profile"
        )
    return "good", ""


def marker_off_mm(profile: Profile, picture: Picture) -> float | None:
    """Return how far the printed marker is from its place; None where it is not visible."""
    camera, known = profile.camera, profile.anchor
    if known is None or camera.colour is None:
        return None
    board = anchor(known.family, known.marker, known.size_mm)
    seen = detect(picture, board)
    if len(seen.picture) < 4:
        return None
    due_px = _corners_px(board.corners(known.marker), known, profile, camera)
    side_px = float(np.linalg.norm(due_px[1] - due_px[0]))
    off_px = float(np.linalg.norm((seen.picture - due_px).mean(axis=0)))
    return off_px * known.size_mm / side_px


def _corners_px(corners_mm: Points, known: Anchor, profile: Profile, camera: Camera) -> Points:
    """(4, 2) where the colour camera sees the corners of a marker that is at its place."""
    assert camera.colour is not None
    camera_from_anchor = profile.surface.camera_from_surface @ np.linalg.inv(
        known.anchor_from_surface
    )
    colour_from_anchor = camera.colour_from_depth @ camera_from_anchor
    places = np.column_stack([corners_mm, np.zeros(4), np.ones(4)])
    return camera.colour.project((places @ colour_from_anchor.T)[:, :3])


def _picture(frame: Frame) -> Picture | None:
    """Return the colour image in grey; None where the frame has none."""
    if isinstance(frame.colour, bytes):
        grey = cv2.imdecode(np.frombuffer(frame.colour, np.uint8), cv2.IMREAD_GRAYSCALE)
        return None if grey is None else np.asarray(grey, np.uint8)
    return frame.colour
