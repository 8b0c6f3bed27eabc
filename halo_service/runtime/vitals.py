"""How the service fares, counted frame by frame. Time comes in by the door."""

from __future__ import annotations

import statistics
from collections import deque
from dataclasses import dataclass
from typing import Literal

from halo_service.runtime.beside import TrackerState

WINDOW = 64
"""Frames over which rate and latency are told: two seconds."""
STALE_S = 2.0
"""Frames sent longer ago than this say nothing of the present rate."""

CameraState = Literal["starting", "running", "lost", "ended"]


@dataclass(frozen=True, slots=True)
class Vitals:
    """One moment's health."""

    fps: float
    latency_ms: float
    """Median from capture received to packet sent; -1 where not known."""
    drops: int
    bad_frames: int
    tracker: TrackerState
    camera: CameraState
    tracker_ms: float
    """Median age of the hands that frames were sensed with; -1 where not known."""


class Pulse:
    """Keeps count over one session."""

    def __init__(self) -> None:
        self.drops = 0
        self.bad_frames = 0
        self.camera: CameraState = "starting"
        self._sent_s: deque[float] = deque(maxlen=WINDOW)
        self._latency_ms: deque[float] = deque(maxlen=WINDOW)
        self._age_ms: deque[float] = deque(maxlen=WINDOW)

    def sent(self, received_s: float, sent_s: float, hands_age_us: int | None) -> None:
        """Count a frame that was sensed and sent; both times from one monotonic clock."""
        self._sent_s.append(sent_s)
        self._latency_ms.append(1000.0 * (sent_s - received_s))
        if hands_age_us is not None:
            self._age_ms.append(hands_age_us / 1000.0)

    def vitals(self, now_s: float, tracker: TrackerState) -> Vitals:
        """Sum it up."""
        recent = [sent for sent in self._sent_s if now_s - sent < STALE_S]
        span_s = recent[-1] - recent[0] if len(recent) > 1 else 0.0
        return Vitals(
            fps=(len(recent) - 1) / span_s if span_s > 0.0 else 0.0,
            latency_ms=_median(self._latency_ms),
            drops=self.drops,
            bad_frames=self.bad_frames,
            tracker=tracker,
            camera=self.camera,
            tracker_ms=_median(self._age_ms),
        )


def _median(values: deque[float]) -> float:
    return statistics.median(values) if values else -1.0
