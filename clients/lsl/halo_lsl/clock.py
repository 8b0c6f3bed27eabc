"""From the time of a frame to LSL's clock.

Rule: pure; clocks are read by the caller. Times are seconds.

A frame's time is that of its exposure, on the service's Unix clock. So the delay of the pipeline
(camera, sensing, network) is not in it, and needs no correction, if the Unix clock of this machine
is that of the service. Else, as with a recorded stream, the delay is estimated from the arrivals.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

SAME_CLOCK_S = 2.0
"""A frame's time that is farther from this machine's Unix time is of another clock."""
FOLLOW = 0.0005
"""How fast the offset follows a Unix clock that was set: the service's time does it so, too."""
WINDOW = 300
"""Arrivals, ten seconds of frames; the fastest of them had the least delay."""


class Kind(StrEnum):
    """How the clocks are compared."""

    AUTO = "auto"
    """`host` if the frame's time is near this machine's Unix time, else `arrival`."""
    HOST = "host"
    """The frame's Unix time is this machine's."""
    ARRIVAL = "arrival"
    """The frame's clock is another one: its fastest arrivals had the known delay."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """The clocks of this machine when a frame arrived."""

    lsl_s: float
    unix_s: float


@dataclass(slots=True)
class Clock:
    """The offset between the frames' clock and LSL's."""

    wanted: Kind = Kind.AUTO
    delay_s: float = 0.0
    """Of the fastest frame from exposure to arrival; used by `arrival` alone."""
    pipeline_s: float = 0.0
    """From exposure to arrival of the last frame; of `arrival`, above the fastest one."""
    kind: Kind | None = None
    """What is used; None before the first frame."""
    _error_s: float | None = None
    """Unix time minus the time in frames, as the service reports it; None before."""
    _offset_s: float | None = None
    _read_s: float = 0.0
    _arrivals: deque[float] = field(default_factory=lambda: deque(maxlen=WINDOW))

    @property
    def reported(self) -> bool:
        """Whether the service has reported the error of its clock."""
        return self._error_s is not None

    def report(self, error_s: float) -> None:
        """Process the service's report: Unix time minus the time in frames.

        The first one is used at once: the host's clock may have been set long ago.
        """
        if self._error_s is None:
            self._offset_s = self.kind = None
        self._error_s = error_s

    def read(self, frame_s: float, now: Arrival) -> None:
        """Process the arrival of a frame."""
        error_s = self._error_s or 0.0
        if self.kind is None:
            near = abs(now.unix_s - error_s - frame_s) < SAME_CLOCK_S
            self.kind = self.wanted
            if self.wanted is Kind.AUTO:
                self.kind = Kind.HOST if near else Kind.ARRIVAL
        if self.kind is Kind.HOST:
            self._follow(now.lsl_s - now.unix_s + error_s, now.lsl_s)
        else:
            self._arrivals.append(now.lsl_s - frame_s)
            self._offset_s = min(self._arrivals) - self.delay_s
        self.pipeline_s = now.lsl_s - self.to_lsl(frame_s)

    def restart(self) -> None:
        """Another session has another clock."""
        self._offset_s = self._error_s = self.kind = None
        self._arrivals.clear()

    def to_lsl(self, frame_s: float) -> float:
        """Return the time on LSL's clock. `read` comes first."""
        if self._offset_s is None:
            raise ValueError("no frame was read yet")
        return frame_s + self._offset_s

    def _follow(self, measured_s: float, now_s: float) -> None:
        """A Unix clock that is set must not move samples: the service reports it a second later."""
        if self._offset_s is None:
            self._offset_s = measured_s
        else:
            most_s = FOLLOW * max(now_s - self._read_s, 0.0)
            step_s = measured_s - self._offset_s
            self._offset_s += min(max(step_s, -most_s), most_s)
        self._read_s = now_s
