"""One place from those that several nodes report of a finger, without a jump.

Rule: pure; times are arguments. Places are weighted by their variances, so the node that sees the
finger better wins, and the weights change smoothly over the surface. Where a node's report ends or
begins at once, the step that would follow is added as an offset, which then decays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from halo_service.canvas.detections import LONGEST_S, Detection, Member, Place

SMOOTHING_S = 0.08
"""Time constant with which weights and offsets follow."""
NEW_SHARE = 0.02
"""Weight with which a second node's report begins, as a share of its later weight."""
LONGEST_STEP_MM = 40.0
"""A longer step is no error of two nodes: the finger was lost and is found again, and the place
jumps."""
STALE_US = 150_000
"""Age, compared to the newest report, from which on a report has no weight."""


class Blend:
    """The reports of one finger."""

    def __init__(self, seen: Detection) -> None:
        self.seen: dict[Member, Detection] = {}
        self._weights: dict[Member, float] = {}
        self._offset: Place = (0.0, 0.0)
        self._offset_us = seen.time_us
        self._last = seen
        """Where the finger was when the last report ended."""
        self._put(seen, 1.0)

    def update(self, seen: Detection) -> None:
        """Replace a report by a newer one, or add one."""
        before = self.seen.get(seen.member)
        if before is None:
            with self._smoothly(seen.time_us):
                self._put(seen, NEW_SHARE if self.seen else 1.0)
            return
        share = 1.0 - math.exp(-max(seen.time_us - before.time_us, 0) / 1e6 / SMOOTHING_S)
        if before.coasts(seen):
            seen = before.coasting(seen)
        self.seen[seen.member] = seen
        self._weights[seen.member] += share * (_weight(seen) - self._weights[seen.member])

    def remove(self, member: Member, time_us: int) -> None:
        """End a node's report."""
        with self._smoothly(time_us):
            self._last = self.seen.pop(member)
            self._weights.pop(member)

    def share(self, member: Member) -> float:
        """Return a member's part of the weight."""
        return self._weights.get(member, 0.0) / sum(self._weights.values(), 1e-9)

    def place_mm(self, time_us: int) -> Place:
        """Return where the finger is at a time."""
        x, y = self._raw(time_us)
        decay = math.exp(-max(time_us - self._offset_us, 0) / 1e6 / SMOOTHING_S)
        return x + decay * self._offset[0], y + decay * self._offset[1]

    def estimate_mm(self, time_us: int) -> Place:
        """Return the most likely place at a time, which may jump where reports begin or end."""
        fresh = [each for _, each in self._fresh(time_us)]
        if not fresh:
            return self._last.at(time_us)
        return _mean_mm([(_weight(each), each.at(time_us)) for each in fresh])

    def mean(self, value: Callable[[Detection], float], of: set[Member], time_us: int) -> float:
        """Return the weighted mean of a value over some members; nan for none."""
        pairs = [(w, value(each)) for w, each in self._fresh(time_us) if each.member in of]
        total = sum(w for w, _ in pairs)
        return sum(w * v for w, v in pairs) / total if total > 0.0 else math.nan

    @property
    def deviation_mm(self) -> float:
        """Standard deviation of the place."""
        weight = sum(map(_weight, self.seen.values())) or _weight(self._last)
        return 1.0 / math.sqrt(weight)

    def best(self) -> Detection:
        """Return the report with the most weight."""
        if not self.seen:
            return self._last
        return self.seen[max(self._weights, key=lambda each: self._weights[each])]

    def _put(self, seen: Detection, share: float) -> None:
        self.seen[seen.member] = seen
        self._weights[seen.member] = share * _weight(seen)

    def _fresh(self, time_us: int) -> Iterator[tuple[float, Detection]]:
        """Yield the weights and reports that count."""
        newest_us = max((each.time_us for each in self.seen.values()), default=time_us)
        for member, each in self.seen.items():
            if newest_us - each.time_us <= STALE_US:
                yield self._weights[member], each

    def _raw(self, time_us: int) -> Place:
        """Return the weighted place; without reports, the last one's for a moment longer."""
        pairs = [(w, each.at(time_us)) for w, each in self._fresh(time_us)]
        return _mean_mm(pairs) if pairs else self._last.at(time_us)

    @contextmanager
    def _smoothly(self, time_us: int) -> Iterator[None]:
        """Add the step of the place that a change makes to the offset."""
        before = self.place_mm(time_us)
        yield
        after = self._raw(time_us)
        lost = math.dist(before, after) > LONGEST_STEP_MM
        self._offset = (0.0, 0.0) if lost else (before[0] - after[0], before[1] - after[1])
        self._offset_us = time_us


def _weight(seen: Detection) -> float:
    return 1.0 / seen.deviation_mm**2


def _mean_mm(places: Sequence[tuple[float, Place]]) -> Place:
    """Return the mean of (weight, place); weights are above 0."""
    total = sum(weight for weight, _ in places)
    return (
        sum(weight * x for weight, (x, _) in places) / total,
        sum(weight * y for weight, (_, y) in places) / total,
    )


def velocity(blend: Blend, time_us: int) -> Place:
    """Return the weighted velocity; 0 for a finger that no node has seen for a moment."""
    members = set(blend.seen)
    vx = blend.mean(lambda each: each.velocity_mm_s[0], members, time_us)
    vy = blend.mean(lambda each: each.velocity_mm_s[1], members, time_us)
    last = blend.best()
    if math.isnan(vx):
        moves = time_us - last.time_us <= LONGEST_S * 1e6
        return last.velocity_mm_s if moves else (0.0, 0.0)
    return vx, vy
