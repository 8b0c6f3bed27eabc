"""The touches that two nodes see at the same time.

Rule: pure; times are arguments. A touch is where its finger was while it touched; the clocks of the
nodes are aligned as those of a canvas.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

import halo_protocol as wire
from halo_service.canvas.clocks import Clock
from halo_service.canvas.detections import Place
from halo_service.canvas.finding.rigid import Places
from halo_service.canvas.touches import SAME_US

MOST = 1024
"""Touches of one surface that are remembered."""
HELD_MM = 12.0
"""A touch that moves farther is no held one: two cameras see different parts of it."""
CLOCK_READY_US = 2_000_000
"""Time after a node's first frame from which on its clock is known well enough."""


@dataclass(frozen=True, slots=True)
class Touched:
    """One touch of one node."""

    time_us: int
    """Of its down, on the clock of this program."""
    place_mm: Place
    """The median place while it touched."""


@dataclass(slots=True)
class _Open:
    time_us: int
    places: deque[Place]


@dataclass(slots=True)
class NodeTouches:
    """The touches of one surface."""

    clock: Clock = field(default_factory=Clock)
    touches: deque[Touched] = field(default_factory=lambda: deque(maxlen=MOST))
    """Those that are over, and were held still."""
    _open: dict[int, _Open] = field(default_factory=dict)
    _first_us: int | None = None

    def receive(self, frame: wire.TouchFrame, arrival_us: int) -> None:
        """Note a frame."""
        time_us = self.clock.arrived(frame.time_us, arrival_us)
        if self._first_us is None:
            self._first_us = time_us
        for down in frame.downs:
            if time_us - self._first_us > CLOCK_READY_US:
                began_us = time_us - round(down.ago_ms * 1000.0)
                self._open[down.id] = _Open(began_us, deque(maxlen=MOST))
        touching = {each.id: each for each in frame.pointers if each.touching}
        for id_, opened in list(self._open.items()):
            if id_ in touching:
                opened.places.append((touching[id_].x_mm, touching[id_].y_mm))
            else:
                del self._open[id_]
                places = np.array(opened.places).reshape(-1, 2)
                if len(places) and np.ptp(places, axis=0).max() <= HELD_MM:
                    x, y = np.median(places, axis=0)
                    self.touches.append(Touched(opened.time_us, (float(x), float(y))))


def pairs(one: Sequence[Touched], other: Sequence[Touched]) -> tuple[Places, Places]:
    """Return the (N, 2) places of touches that both saw, on each surface.

    A touch that could be several of the other node's is left out.
    """
    found = []
    for a in one:
        near = [b for b in other if abs(a.time_us - b.time_us) <= SAME_US]
        if len(near) == 1 and sum(abs(near[0].time_us - c.time_us) <= SAME_US for c in one) == 1:
            found.append((a.place_mm, near[0].place_mm))
    here = np.array([a for a, _ in found], dtype=np.float64).reshape(-1, 2)
    there = np.array([b for _, b in found], dtype=np.float64).reshape(-1, 2)
    return here, there
