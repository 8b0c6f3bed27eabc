"""When a frame of the canvas is sent.

Rule: pure; times are arguments. A frame is sent with each frame of one node, the lead: the fastest
one that sees fingers. So the canvas has the rate of the fastest node, and what the lead sees waits
for nothing; what others see waits for at most one frame. A touch that begins or ends is sent at
once, whoever sees it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median

from halo_service.canvas.detections import SurfaceKey

INTERVALS = 16
"""Number of intervals between a node's frames; its period is their median."""
AS_FAST = 1.25
"""Largest ratio of its period to the shortest one at which a node may lead."""
AWAY_US = 500_000
"""A node leads no longer after this time without a frame."""
LATE = 1.5
"""Periods after which the frame of another node is sent in place of the lead's."""
IDLE_US = 500_000
"""Longest time between two frames of the canvas, so that clients see that it is there."""


@dataclass(slots=True)
class _Node:
    times_us: deque[int] = field(default_factory=lambda: deque(maxlen=INTERVALS + 1))
    pointers: int = 0

    @property
    def period_us(self) -> float:
        """Median interval of the frames."""
        if len(self.times_us) < 2:
            return float(AWAY_US)
        return max(median(later - before for before, later in pairwise(self.times_us)), 1.0)


class Pace:
    """Follows the nodes and decides when to send."""

    def __init__(self) -> None:
        self._nodes: dict[SurfaceKey, _Node] = {}
        self._sent_us: int | None = None
        self.lead: SurfaceKey | None = None
        """The node with whose frames frames are sent."""

    @property
    def rate_hz(self) -> float:
        """Frames a second of the fastest node; 0 without one."""
        periods = [each.period_us for each in self._nodes.values() if len(each.times_us) > 1]
        return 1e6 / min(periods) if periods else 0.0

    def arrived(self, surface: SurfaceKey, now_us: int, pointers: int) -> bool:
        """Note a node's frame; return whether to send one now."""
        node = self._nodes.setdefault(surface, _Node())
        node.times_us.append(now_us)
        node.pointers = pointers
        self._choose(now_us)
        if surface == self.lead or self._sent_us is None:
            return True
        assert self.lead is not None
        return now_us - self._sent_us > LATE * self._nodes[self.lead].period_us

    def is_idle(self, now_us: int) -> bool:
        """Whether nothing was sent for long."""
        return self._sent_us is None or now_us - self._sent_us >= IDLE_US

    def sent(self, now_us: int) -> None:
        """Note that a frame was sent."""
        self._sent_us = now_us

    def lose(self, surface: SurfaceKey) -> None:
        """Forget a node that is gone."""
        self._nodes.pop(surface, None)
        self.lead = None if self.lead == surface else self.lead

    def _choose(self, now_us: int) -> None:
        """Choose the lead; it stays while it is as fast as any, and sees fingers if any does."""
        there = {w: n for w, n in self._nodes.items() if now_us - n.times_us[-1] < AWAY_US}
        fastest_us = min(each.period_us for each in there.values())
        fast = {w: n for w, n in there.items() if n.period_us <= AS_FAST * fastest_us}
        lead = fast.get(self.lead) if self.lead is not None else None
        most = max(fast, key=lambda each: fast[each].pointers)
        if lead is None or (lead.pointers == 0 and fast[most].pointers > 0):
            self.lead = most
