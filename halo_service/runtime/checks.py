"""Which captures can be sensed: pure, one question a frame."""

from __future__ import annotations

from dataclasses import dataclass

import cv2

from halo_service.values import BadFrame, Frame

JUMP_US = 1_000_000
"""A gap longer than this is no dropped frame: the clock jumped or the camera slept."""


@dataclass(frozen=True, slots=True)
class Judged:
    """What one capture is worth."""

    fault: str | None
    """Why it cannot be sensed, or None."""
    missed: int
    """Frames that the camera made since the last one and that never came."""


def judge(capture: Frame | BadFrame, last_us: int | None, fps: float) -> Judged:
    """Judge a capture. `last_us`: the time of the one before, None for the first."""
    elapsed_us = None if last_us is None else capture.time_us - last_us
    if elapsed_us is not None and elapsed_us <= 0:
        return Judged(f"time went back by {-elapsed_us} us", 0)
    if elapsed_us is not None and elapsed_us > JUMP_US:
        return Judged(f"time jumped by {elapsed_us / 1e6:.1f} s", 0)
    missed = 0 if elapsed_us is None or fps <= 0 else max(round(elapsed_us * fps / 1e6) - 1, 0)
    if isinstance(capture, BadFrame):
        return Judged(capture.reason, missed)
    if not cv2.hasNonZero(capture.depth):
        return Judged("no pixel has depth", missed)
    return Judged(None, missed)
