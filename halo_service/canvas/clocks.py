"""A node's clock, estimated from when its frames arrive.

Rule: pure; times are arguments. A frame never arrives before it was sent, and now and then one
arrives with almost no waiting. So the line under all delays over time is the clock's offset and
drift (Moon, Skelly and Towsley, Estimation and removal of clock skew, 1999): the line below all
points that is nearest to them, an edge of their lower convex hull.

One-way messages cannot separate the shortest delay from the offset. What a node reports as its own
latency is subtracted; the network's shortest delay remains in the estimate.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from dataclasses import dataclass
from statistics import median

BIN_US = 500_000
"""Of each half second the shortest delay is used."""
BINS = 60
"""30 s, in which a crystal's drift is constant."""
LEAST_SPAN_US = 5_000_000
"""Shorter ones say nothing about a drift."""
MAX_DRIFT = 600e-6
"""A service follows its host's clock by 500e-6, a crystal is off by at most 100e-6."""
EARLY_US = 60_000
"""A frame arrives this much before it can: the node's clock was set, or the way is shorter."""
LATE_US, LATE_FOR_US = 60_000, 3_000_000
"""The same where all frames of this time are this late; a network pauses for a shorter time."""
BACK_US = 500_000
"""The time of frames goes back this much: a recording starts again."""
SLEW = 0.05
"""Most that the used offset changes per time, so that no pointer jumps."""

Point = tuple[int, int]
"""(time of sending in us, delay in us)."""


@dataclass(frozen=True, slots=True)
class ClockFit:
    """The line under the delays."""

    at_us: int
    """Time of the node's clock at which `delay_us` is meant."""
    delay_us: float
    """Shortest delay: the canvas's clock minus the node's, plus the shortest way."""
    drift: float
    """Change of the delay per time: 1e-6 is one microsecond a second."""
    deviation_us: float
    """Median distance of the shortest delays of each half second from the line."""
    span_us: int
    """Between the first and the last of these."""

    def delay_at(self, sent_us: int) -> float:
        """Return the shortest delay of a frame that is sent at a time."""
        return self.delay_us + self.drift * (sent_us - self.at_us)

    @property
    def drift_deviation(self) -> float:
        """Standard deviation of the drift, about; that of a crystal where the span is short."""
        if self.span_us < LEAST_SPAN_US:
            return 100e-6
        return self.deviation_us / self.span_us


class Clock:
    """The clock of one session of a node."""

    def __init__(self, latency_us: float = 0.0, restarts: int = 0) -> None:
        """`latency_us`, `restarts`: what the attributes begin with."""
        self._points: deque[Point] = deque(maxlen=BINS)
        self._last_us: int | None = None
        self._used_us: float | None = None
        self._late_since_us: int | None = None
        self.fit: ClockFit | None = None
        self.restarts = restarts
        """How often the estimate began again: the node's clock was set, or its way changed."""
        self.latency_us = latency_us
        """What the node itself needs from exposure to sending, as it reports."""

    @property
    def behind_us(self) -> float:
        """Return how far the node's clock is behind, with the shortest time on the way."""
        if self.fit is None or self._last_us is None:
            return 0.0
        return self.fit.delay_at(self._last_us) - self.latency_us

    def arrived(self, sent_us: int, arrival_us: int) -> int:
        """Note a frame; return its time on the canvas's clock.

        `sent_us`: the frame's time on the node's clock; `arrival_us`: on the canvas's.
        """
        if self._jumped(sent_us, arrival_us):
            self.__init__(self.latency_us, self.restarts + 1)  # type: ignore[misc]
        self._add(sent_us, arrival_us - sent_us)
        here_us = sent_us + round(self._shift_us(sent_us))
        self._last_us = sent_us
        return min(here_us, arrival_us)

    def _jumped(self, sent_us: int, arrival_us: int) -> bool:
        if self.fit is None or self._last_us is None:
            return False
        late_us = arrival_us - sent_us - self.fit.delay_at(sent_us)
        if late_us <= LATE_US:
            self._late_since_us = None
        elif self._late_since_us is None:
            self._late_since_us = arrival_us
        late = self._late_since_us is not None and arrival_us - self._late_since_us > LATE_FOR_US
        return late or late_us < -EARLY_US or sent_us < self._last_us - BACK_US

    def _add(self, sent_us: int, delay_us: int) -> None:
        """Keep the shortest delay of each half second; fit again where that changed."""
        if self._points and self._points[-1][0] // BIN_US == sent_us // BIN_US:
            if delay_us >= self._points[-1][1]:
                return
            self._points.pop()
        self._points.append((sent_us, delay_us))
        self.fit = line_under(list(self._points))

    def _shift_us(self, sent_us: int) -> float:
        """Return what to add to a frame's time; it follows the estimate slowly."""
        assert self.fit is not None
        wanted_us = self.fit.delay_at(sent_us) - self.latency_us
        if self._used_us is None or self._last_us is None:
            self._used_us = wanted_us
        most_us = SLEW * max(0, sent_us - (self._last_us or sent_us))
        self._used_us += min(max(wanted_us - self._used_us, -most_us), most_us)
        return self._used_us


def line_under(points: list[Point]) -> ClockFit:
    """Return the line under one or more points, in order of time, that is nearest to them all."""
    first_us, last_us = points[0][0], points[-1][0]
    span_us = last_us - first_us
    drift, through = 0.0, min(points, key=lambda each: each[1])
    if span_us >= LEAST_SPAN_US:
        hull = _lower_hull(points)
        middle_us = sum(sent_us for sent_us, _ in points) / len(points)
        after = min(max(bisect_left([x for x, _ in hull], middle_us), 1), len(hull) - 1)
        (x1, y1), (x2, y2) = hull[after - 1], hull[after]
        drift = min(max((y2 - y1) / (x2 - x1), -MAX_DRIFT), MAX_DRIFT)
        through = min(hull, key=lambda each: each[1] - drift * (each[0] - first_us))
    at_us, delay_us = through
    over_us = median(y - delay_us - drift * (x - at_us) for x, y in points)
    return ClockFit(at_us, float(delay_us), drift, float(over_us), span_us)


def _lower_hull(points: list[Point]) -> list[Point]:
    """Return the points on the lower side of the convex hull, in order of time."""
    hull: list[Point] = []
    for x, y in points:
        while len(hull) >= 2 and _is_above(hull[-2], hull[-1], (x, y)):
            hull.pop()
        hull.append((x, y))
    return hull


def _is_above(a: Point, b: Point, c: Point) -> bool:
    """Whether b is on or above the line from a to c."""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])
