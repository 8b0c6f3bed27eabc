"""Read a timeline: the pose at any time, with tremor and sway added.

Rule: pure; time is an argument.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from halo_service.virtual.motion import Contact, Segment
from halo_service.virtual.skeleton import FingerPose

TREMOR_MM = 0.12
"""Amplitude of the physiological tremor of 8 to 12 Hz in a free finger, chosen within published
ranges."""
SWAY_MM = 0.5
"""Amplitude of a held arm's slow sway, chosen."""


class TimelineReader:
    """Reads segments as far as time has come."""

    def __init__(
        self, segments: Iterator[Segment], rng: np.random.Generator, turn_deg: float = 0.0
    ) -> None:
        """`turn_deg` is added to every yaw: where the user sits."""
        self._turn_deg = turn_deg
        self._source = segments
        self._recent: list[Segment] = []
        self._started: list[Contact] = []
        self.finished = False
        """Whether the timeline has ended; the last pose then stays."""
        self._phase = rng.uniform(0.0, 2.0 * np.pi, (3, 4))
        self._pace = np.concatenate([rng.uniform(0.3, 0.9, (3, 2)), rng.uniform(8, 12, (3, 2))], 1)

    def at(self, t_s: float) -> FingerPose:
        """The pose at a time; times may not go back by more than a second."""
        segment = self._segment(t_s)
        return self._with_tremor(segment.pose(min(t_s, segment.end_s)), t_s)

    def tool_at(self, t_s: float) -> str | None:
        """What the finger rests on."""
        return self._segment(t_s).tool

    def started_contacts(self, t_s: float) -> list[Contact]:
        """Touches that started since the last call."""
        ready = [c for c in self._started if c.from_s <= t_s]
        self._started = [c for c in self._started if c.from_s > t_s]
        return ready

    def _segment(self, t_s: float) -> Segment:
        while not self._recent or self._recent[-1].end_s <= t_s:
            segment = next(self._source, None)
            if segment is None:
                self.finished = True
                return self._recent[-1]
            if segment.contact is not None:
                self._started.append(segment.contact)
            self._recent = [s for s in self._recent if s.end_s > t_s - 1.0] + [segment]
        for segment in reversed(self._recent):
            if segment.start_s <= t_s:
                return segment
        return self._recent[0]

    def _with_tremor(self, pose: FingerPose, t_s: float) -> FingerPose:
        """Add tremor and sway; none in height at contact, little along the table."""
        waves = np.sin(2.0 * np.pi * self._pace * t_s + self._phase)
        shake = waves @ np.array([SWAY_MM, SWAY_MM, TREMOR_MM, TREMOR_MM]) / 2.0
        loose = min(1.0, pose.height_mm / 8.0)
        along = 0.15 + 0.85 * loose
        return dataclasses.replace(
            pose,
            x_mm=pose.x_mm + float(shake[0]) * along,
            y_mm=pose.y_mm + float(shake[1]) * along,
            height_mm=max(0.0, pose.height_mm + float(shake[2]) * loose),
            yaw_deg=pose.yaw_deg + self._turn_deg,
        )
