"""What the service leaves out first when the machine is busy: looks of the hand tracker.

The order: first the hand tracker gets fewer frames, then fewer still; then frames are left out, the
newest is sensed. A packet never waits. Between two looks the sensing follows fingers by itself, so
fewer looks cost little: new fingers appear later.
"""

from __future__ import annotations

from collections import deque
from typing import Literal

LOOK_US = (0, 100_000, 200_000)
"""Least time between two frames for the hand tracker, by the level of load."""
LEVELS = (
    "every frame may go to the hand tracker",
    "the hand tracker gets ten frames a second",
    "the hand tracker gets five frames a second",
)
LoadState = Literal["none", "reduced", "least", "dropping"]
LOADS: tuple[LoadState, ...] = ("none", "reduced", "least", "dropping")
"""How `health` names the levels; the last one: frames are left out, too."""
LATE_SHARE = 0.6
"""A frame whose packet needs more than this share of a frame's time is late (chosen: the rest is
for reading the next frame)."""
IDLE_S = 0.001
"""A loop that waited less than this for a frame had no time left."""
WINDOW, MOST_LATE = 30, 6
"""With so many late frames of so many the load is high (chosen: single ones are normal)."""
CALM = 150
"""Frames in a row with at most `CALM_LATE` late ones, five seconds at 30 a second, after which it
is lower."""
CALM_LATE = 3


class LoadWatch:
    """The level of load, from how long frames took. Time is an argument."""

    def __init__(self) -> None:
        self.level = 0
        """0: none, else an index into `LOOK_US`."""
        self._late: deque[bool] = deque(maxlen=WINDOW)
        self._calm = self._calm_late = 0

    def see(self, waited_s: float, spent_s: float, missed: int, period_s: float) -> bool:
        """Count one frame; return whether the level changed.

        `waited_s`: for the frame; `spent_s`: from there to its packet; `missed`: frames that were
        lost before it; `period_s`: the camera's.
        """
        late = spent_s > LATE_SHARE * period_s or (missed > 0 and waited_s < IDLE_S)
        self._late.append(late)
        self._calm += 1
        self._calm_late += late
        if sum(self._late) >= MOST_LATE:
            return self._turn_to(min(self.level + 1, len(LOOK_US) - 1))
        if self._calm_late > CALM_LATE:
            self._calm = self._calm_late = 0
        if self._calm >= CALM:
            return self._turn_to(max(self.level - 1, 0))
        return False

    def _turn_to(self, level: int) -> bool:
        changed, self.level = level != self.level, level
        self._late.clear()
        self._calm = self._calm_late = 0
        return changed
