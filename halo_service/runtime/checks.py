"""Which captures can be sensed: a pure check of each."""

from __future__ import annotations

from dataclasses import dataclass

import cv2

from halo_service.values import BadFrame, Frame

JUMP_US = 1_000_000
"""A longer gap is not a dropped frame: the clock jumped or the camera slept."""


@dataclass(frozen=True, slots=True)
class CaptureCheck:
    """The result for one capture."""

    fault: str | None
    """Why it cannot be sensed, or None."""
    missed: int
    """Frames that the camera captured since the last one and that never arrived."""


def check_capture(capture: Frame | BadFrame, last_us: int | None, fps: float) -> CaptureCheck:
    """Check a capture. `last_us`: the time of the one before, None for the first."""
    elapsed_us = None if last_us is None else capture.time_us - last_us
    if elapsed_us is not None and elapsed_us <= 0:
        return CaptureCheck(f"time went back by {-elapsed_us} us", 0)
    if elapsed_us is not None and elapsed_us > JUMP_US:
        return CaptureCheck(f"time jumped by {elapsed_us / 1e6:.1f} s", 0)
    missed = 0 if elapsed_us is None or fps <= 0 else max(round(elapsed_us * fps / 1e6) - 1, 0)
    if isinstance(capture, BadFrame):
        return CaptureCheck(capture.reason, missed)
    if not cv2.hasNonZero(capture.depth):
        return CaptureCheck("no pixel has depth", missed)
    return CaptureCheck(None, missed)
