"""When a task is done, read off the finger itself. Pure: time is an argument.

Nothing is timed by a clock that the hand must follow. A touch is done when the finger has been down
and has left. A level is done when the finger was still and then held for a second. Without a hand
in view, nothing happens: that is a pause.
"""

from __future__ import annotations

from collections import deque
from enum import Enum

import numpy as np

from halo_calibration.observe import Observation
from halo_calibration.solvers.dwell import LEAST_OF_TOUCH, LIFTED
from halo_calibration.solvers.touch import NO_HALO_MM_PX
from halo_service.app.first_light.plan import Kind

GONE_S = 0.2
"""A finger that is not seen for so long has left."""
LONGEST_TOUCH_S = 4.0
"""A touch that lasts longer counts as done: the finger may rest."""
PATIENCE_S = 8.0
"""A finger that is seen for so long and was never felt: the touch counts as missed."""
SETTLED_S = {"hover": 1.0, "pressure": 1.5}
"""How long a finger must be still before it is measured: a scale needs time to be read."""
HOLD_S = 1.0
"""How long it is measured."""
STILL_MM = 8.0
"""A still fingertip is found within this for 90 % of the time; the calibration wants 5 mm."""
STEADY, NOISE = 0.35, 0.25
"""A still finger's halo varies by less than this share of its median, or of a touch's halo."""
ATTEMPTS = 3
"""So often a level may be lost while it is measured."""
LEAST_SEEN = 0.7


class State(Enum):
    """How far a task is."""

    WAITING = "waiting"
    DOWN = "down"
    HOLDING = "holding"
    DONE = "done"
    MISSED = "missed"
    """The finger was there and was not felt, or did not hold still."""


class Pace:
    """Follows one task."""

    def __init__(self, kind: Kind, touch_raw: float) -> None:
        """`touch_raw`: the halo of this user's relaxed touch, mm px."""
        self.kind = kind
        self.state = State.WAITING
        self.from_us = 0
        """When the finger came down, or began to hold; valid after WAITING."""
        self.to_us = 0
        """When it left, or ended to hold; valid when DONE or MISSED."""
        self.again = 0
        """How often a level was lost while it was measured."""
        self._touch_raw = touch_raw
        self._least = max(NO_HALO_MM_PX, LEAST_OF_TOUCH * touch_raw)
        self._most = 0.0
        self._seen_us = 0
        """How long a finger was seen while it was waited for."""
        self._last_us: int | None = None
        self._gone_us: int | None = None
        self._recent: deque[tuple[int, Observation | None]] = deque()

    def feed(self, now_us: int, seen: Observation | None) -> State:
        """Process one frame's finger."""
        step_us = 0 if self._last_us is None else now_us - self._last_us
        self._last_us = now_us
        if self.state is State.WAITING and seen is not None:
            self._seen_us += step_us
        if self.kind in ("touch", "tap"):
            self._touch(now_us, seen)
        else:
            self._level(now_us, seen)
        return self.state

    def _touch(self, now_us: int, seen: Observation | None) -> None:
        felt = seen is not None and seen.raw >= self._least
        if self.state is State.WAITING:
            if felt:
                self.state, self.from_us = State.DOWN, now_us
            elif self._seen_us > PATIENCE_S * 1e6:
                self._end(State.MISSED, now_us)
        elif self.state is State.DOWN:
            self._most = max(self._most, seen.raw if seen else 0.0)
            if self._has_left(now_us, seen) or now_us - self.from_us > LONGEST_TOUCH_S * 1e6:
                self._end(State.DONE, now_us)

    def _has_left(self, now_us: int, seen: Observation | None) -> bool:
        if seen is not None:
            self._gone_us = None
            return seen.raw < LIFTED * self._most
        self._gone_us = now_us if self._gone_us is None else self._gone_us
        return now_us - self._gone_us >= GONE_S * 1e6

    def _level(self, now_us: int, seen: Observation | None) -> None:
        self._recent.append((now_us, seen))
        span_us = (HOLD_S if self.state is State.HOLDING else SETTLED_S[self.kind]) * 1e6
        if self.state is State.HOLDING:
            if now_us - self.from_us < span_us:
                return
            if self._is_still():
                self._end(State.DONE, now_us)
                return
            self.again += 1
            self._recent.clear()
            self.state = State.WAITING
            if self.again >= ATTEMPTS:
                self._end(State.MISSED, now_us)
            return
        while self._recent and now_us - self._recent[0][0] > span_us:
            self._recent.popleft()
        full = bool(self._recent) and now_us - self._recent[0][0] >= 0.9 * span_us
        if full and self._is_still():
            self.state, self.from_us = State.HOLDING, now_us
            self._recent.clear()
        elif self._seen_us > 3.0 * PATIENCE_S * 1e6:
            self._end(State.MISSED, now_us)

    def _is_still(self) -> bool:
        fingers = [seen for _, seen in self._recent if seen is not None]
        if len(fingers) < max(LEAST_SEEN * len(self._recent), 3):
            return False
        where = np.array([(each.x_mm, each.y_mm) for each in fingers])
        off = np.hypot(*(where - np.median(where, axis=0)).T)
        raw = np.array([each.raw for each in fingers])
        middle = float(np.median(raw))
        if self.kind == "pressure" and middle < self._least:
            return False
        varies = float(np.subtract(*np.percentile(raw, [90, 10])))
        return bool(np.percentile(off, 90) <= STILL_MM) and varies <= max(
            STEADY * middle, NOISE * self._touch_raw
        )

    def _end(self, state: State, now_us: int) -> None:
        if self.state is State.WAITING:
            self.from_us = now_us
        self.state, self.to_us = state, now_us
