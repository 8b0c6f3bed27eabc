"""Touches: which true ones were recognised, and which published ones are false.

Rule: each true touch is scored once, and there are no retries. A published down belongs to a true
touch by its time and place alone; the published `ago_ms` is measured (see `timing`), not trusted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from halo_service.evaluation.metrics.truth import TrueTouch, Truth
from halo_service.values import Finger, Side, TouchEvent, TouchFrame

WITHIN_MM = 25.0
"""A touch counts within this of its target (paper 5.2.1)."""
EARLY_US = 70_000
"""Chosen: two frames. An earlier down was reported for a finger in the air."""
LATE_US = 100_000
"""Chosen: a frame of the paper's detector, one of its debounce, and one that was dropped."""
IMPOSSIBLE_US = 1e12
"""Cost of a pair that cannot match, us; any number far above the others."""


@dataclass(frozen=True, slots=True)
class Down:
    """A touch as it was published."""

    id: int
    side: Side
    finger: Finger
    time_us: int
    """Of the frame that reported it."""
    x_mm: float
    y_mm: float
    strike_mm_s: float
    ago_ms: float
    up_us: int | None
    """Of the frame that reported its end; None where none did."""
    up_ago_ms: float
    confidence: float = field(compare=False)
    """Of its pointer in that frame; nan, which equals nothing, where it had none."""


@dataclass(frozen=True, slots=True)
class Hit:
    """A true touch and the down that reported it."""

    touch: TrueTouch
    down: Down
    frames_late: int
    """Frames from the first in contact to the one that reported it; negative: early."""
    true_mm: tuple[float, float]
    """Where the pad was in the frame that reported it, surface frame."""

    @property
    def off_mm(self) -> float:
        """How far from there it was reported."""
        return math.dist((self.down.x_mm, self.down.y_mm), self.true_mm)


@dataclass(frozen=True, slots=True)
class Touches:
    """The touches of one recording, or of many."""

    hits: tuple[Hit, ...] = ()
    missed: tuple[TrueTouch, ...] = ()
    doubled: tuple[Down, ...] = ()
    """Further downs during a touch that had one."""
    outside: tuple[Down, ...] = ()
    """Reported while a finger touched, but farther than WITHIN_MM from its target."""
    ghosts: tuple[Down, ...] = ()
    """Reported while nothing touched."""
    between_frames: tuple[TrueTouch, ...] = ()
    """True touches that no frame shows: counted separately."""
    between_frames_hits: int = 0
    """How many of them were reported all the same."""

    @property
    def true(self) -> int:
        """Touches that at least one frame shows."""
        return len(self.hits) + len(self.missed)

    @property
    def false(self) -> int:
        """Published downs that are no touch of their own."""
        return len(self.doubled) + len(self.outside) + len(self.ghosts)

    @property
    def precision(self) -> float:
        """Share of the published downs that are hits; 1 where nothing was published."""
        reported = len(self.hits) + self.false
        return len(self.hits) / reported if reported else 1.0

    @property
    def recall(self) -> float:
        """Share of the true touches that were reported; 1 where there were none."""
        return len(self.hits) / self.true if self.true else 1.0

    @property
    def f1(self) -> float:
        """Harmonic mean of the two."""
        both = self.precision + self.recall
        return 2.0 * self.precision * self.recall / both if both else 0.0


def score_touches(frames: Sequence[TouchFrame], truth: Truth) -> Touches:
    """Match published downs with true touches."""
    downs = published(frames)
    touches = truth.touches
    hit_by = _pairs(downs, touches)
    paired = set(hit_by.values())
    rest = [down for index, down in enumerate(downs) if index not in paired]
    doubled = [down for down in rest if any(fits(down, touch) for touch in touches)]
    others = [down for down in rest if down not in doubled]
    outside = [down for down in others if any(_overlaps(down, touch) for touch in touches)]
    times = [frame.time_us for frame in frames]
    counted = {k: touch for k, touch in enumerate(touches) if touch.ended and not touch.beyond}
    whole = {k: touch for k, touch in counted.items() if touch.frames}
    unseen = {k: touch for k, touch in counted.items() if not touch.frames}
    return Touches(
        tuple(
            _hit(touch, downs[hit_by[k]], truth, times) for k, touch in whole.items() if k in hit_by
        ),
        tuple(touch for k, touch in whole.items() if k not in hit_by),
        tuple(doubled),
        tuple(outside),
        tuple(down for down in others if down not in outside),
        tuple(unseen.values()),
        sum(k in hit_by for k in unseen),
    )


def fits(down: Down, touch: TrueTouch) -> bool:
    """Whether a down can be the report of a touch: by time and distance from the target."""
    x, y = touch.aim_mm
    return _overlaps(down, touch) and bool(np.hypot(down.x_mm - x, down.y_mm - y) <= WITHIN_MM)


def published(frames: Sequence[TouchFrame]) -> list[Down]:
    """Return every published touch with its end, in order of time."""
    ups = [
        (frame.time_us, event) for frame in frames for event in frame.events if event.kind == "up"
    ]
    return [
        _down(frame, event, _end(frame.time_us, event, ups))
        for frame in frames
        for event in frame.events
        if event.kind == "down"
    ]


def _end(
    from_us: int, down: TouchEvent, ups: Sequence[tuple[int, TouchEvent]]
) -> tuple[int, TouchEvent] | None:
    later = (each for each in ups if each[0] > from_us and each[1].id == down.id)
    return next(later, None)


def _down(frame: TouchFrame, event: TouchEvent, up: tuple[int, TouchEvent] | None) -> Down:
    who = next((p for p in frame.pointers if p.id == event.id), None)
    return Down(
        event.id,
        who.side if who else Side.UNKNOWN,
        who.finger if who else Finger.INDEX,
        frame.time_us,
        event.x_mm,
        event.y_mm,
        event.strike_mm_s,
        event.ago_ms,
        up[0] if up else None,
        up[1].ago_ms if up else 0.0,
        who.confidence if who else math.nan,
    )


def _pairs(downs: Sequence[Down], touches: Sequence[TrueTouch]) -> dict[int, int]:
    """Index of touch -> index of its down: as many pairs as possible, the nearest in time."""
    cost = _cost(downs, touches)
    rows, columns = linear_sum_assignment(cost)
    return {
        int(row): int(column)
        for row, column in zip(rows, columns, strict=True)
        if cost[row, column] < IMPOSSIBLE_US
    }


def _cost(downs: Sequence[Down], touches: Sequence[TrueTouch]) -> NDArray[np.float64]:
    """(touches, downs) us from contact to the reporting frame; IMPOSSIBLE_US: no match."""
    cost = np.full((len(touches), len(downs)), IMPOSSIBLE_US)
    for row, touch in enumerate(touches):
        for column, down in enumerate(downs):
            if fits(down, touch):
                cost[row, column] = abs(down.time_us - touch.from_us)
    return cost


def _overlaps(down: Down, touch: TrueTouch) -> bool:
    return touch.from_us - EARLY_US <= down.time_us <= touch.to_us + LATE_US


def _hit(touch: TrueTouch, down: Down, truth: Truth, times: Sequence[int]) -> Hit:
    reported = np.searchsorted(times, down.time_us)
    frame = truth.at(down.time_us)
    finger = frame.find(touch.side, touch.finger) if frame else None
    true_mm = (finger.x_mm, finger.y_mm) if finger else (touch.x_mm, touch.y_mm)
    return Hit(touch, down, int(reported - np.searchsorted(times, touch.from_us)), true_mm)
