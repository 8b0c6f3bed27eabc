"""The state of the service, counted frame by frame. Time is an argument."""

from __future__ import annotations

import statistics
from collections import deque
from dataclasses import dataclass
from typing import Literal, NamedTuple

from halo_service.runtime.load import LOADS, LoadState
from halo_service.runtime.memory import UNKNOWN, memory_mb
from halo_service.runtime.tracker_thread import TrackerState

WINDOW = 128
"""Frames remembered: more than a second at the highest frame rate."""
RECENT_S = 1.0
"""Health covers the last second (protocol 1)."""

CameraState = Literal["starting", "running", "lost", "ended"]


@dataclass(frozen=True, slots=True)
class Health:
    """The state at one moment."""

    fps: float
    latency_ms: float
    """Median from capture received to packet sent; -1 if unknown."""
    drops: int
    bad_frames: int
    tracker: TrackerState
    camera: CameraState
    tracker_ms: float
    """Median age of the hands that frames were sensed with; -1 if unknown."""
    memory_mb: int = UNKNOWN
    """Memory of the process."""
    load: LoadState = "none"
    """What is left out because the machine is busy."""
    looks_hz: float = -1.0
    """Images a second at which the hand model looked; -1 if unknown."""


class HealthCounter:
    """Counts over one session."""

    def __init__(self) -> None:
        self.drops = 0
        self.bad_frames = 0
        self.camera: CameraState = "starting"
        self._sent: deque[_Sent] = deque(maxlen=WINDOW)

    def sent(
        self, received_s: float, sent_s: float, hands_age_us: int | None, looks: int = 0
    ) -> None:
        """Count a frame that was sensed and sent; both times from one monotonic clock.

        `looks`: how many images the hand model has got so far.
        """
        age_ms = None if hands_age_us is None else hands_age_us / 1000.0
        latency_ms = 1000.0 * (sent_s - received_s)
        self._sent.append(_Sent(sent_s, latency_ms, age_ms, looks, self.drops))

    def health(self, now_s: float, tracker: TrackerState, level: int = 0) -> Health:
        """Summarise the last second. `level`: of load, see `LoadWatch`."""
        recent = [sent for sent in self._sent if now_s - sent.time_s <= RECENT_S]
        span_s = recent[-1].time_s - recent[0].time_s if len(recent) > 1 else 0.0
        return Health(
            fps=(len(recent) - 1) / span_s if span_s > 0.0 else 0.0,
            latency_ms=_median([sent.latency_ms for sent in recent]),
            drops=self.drops,
            bad_frames=self.bad_frames,
            tracker=tracker,
            camera=self.camera,
            tracker_ms=_median([sent.age_ms for sent in recent if sent.age_ms is not None]),
            memory_mb=memory_mb(),
            load=_load(level, recent),
            looks_hz=-1.0 if tracker == "off" else _looks_hz(recent),
        )


SLOW, WELL = 0.85, 0.95
"""Shares of the camera's frames: below the first a service is slow, above the second it is not."""
SLOW_IN_A_ROW = 3
"""Reports that must agree."""


class SlowWatch:
    """Notices that a service senses fewer frames than its camera captures."""

    def __init__(self) -> None:
        self._slow = False
        self._count = 0

    def see(self, fps: float, camera_fps: float) -> str:
        """Return the sentence to log when this begins or ends, else an empty text.

        `fps`: of the last second, 0 where no frame is sensed at all: other warnings say why.
        """
        share = fps / camera_fps if camera_fps > 0.0 else 1.0
        differs = share > WELL if self._slow else 0.0 < share < SLOW
        self._count = self._count + 1 if differs else 0
        if self._count < SLOW_IN_A_ROW:
            return ""
        self._slow, self._count = not self._slow, 0
        if not self._slow:
            return f"speed: {fps:.0f} frames a second again"
        return (
            f"speed: only {fps:.0f} of {camera_fps:.0f} frames a second are sensed, so touches are "
            "late or lost; close other programs, or use a faster machine"
        )


class _Sent(NamedTuple):
    time_s: float
    latency_ms: float
    age_ms: float | None
    looks: int
    """In this session so far, as the next."""
    drops: int


def _load(level: int, recent: list[_Sent]) -> LoadState:
    dropping = bool(recent) and recent[-1].drops > recent[0].drops
    return "dropping" if level == len(LOADS) - 2 and dropping else LOADS[level]


def _looks_hz(recent: list[_Sent]) -> float:
    span_s = recent[-1].time_s - recent[0].time_s if recent else 0.0
    return (recent[-1].looks - recent[0].looks) / span_s if span_s > 0.0 else -1.0


def _median(values: list[float]) -> float:
    return statistics.median(values) if values else -1.0
