"""When the hand model looks at a frame: only where depth does not confirm the hands it found last.

Between two looks the sensing follows each finger by its own silhouette, so a second look at hands
that are where they were says nothing new. The decision depends on frames alone, never on a clock:
a recording gives the same looks as the live camera.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.hand_tracking.regions import (
    HAND_MM,
    LEAST_AREA_MM2,
    PALM,
    REDUCE,
    Heights,
    Mask,
    without_hands,
)
from halo_service.values import Frame, Hand, Tracked

LOOK_US = 115_000
"""Hands that depth confirms are looked at again after this: every fourth frame of 30 a second.
Their age stays below the 150 ms that the sensing accepts."""
SETTLED = 3
"""Looks in a row that must agree before frames are left out."""
SEARCH_US = 1_000_000
"""What belongs to no hand is searched in every frame for so long; after that it is an object."""
SURE = 0.8
"""A hand with less confidence is looked at in every frame."""
NEAR_MM = 30.0
"""Palms of two looks in a row that are one hand."""
CAME_MM, CAME_MM2 = 25.0, 400.0
"""Something came in, or a hand went away from its place, where so large an area is above the
surface and farther than this from all that was there at the last look: a finger's breadth."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What the model and the depth showed in the last frame that the model got."""

    tracked: Tracked
    near: Mask
    """Reduced pixels at or near something above the surface."""
    settled: int
    """Looks in a row that found the same hands."""
    searched_us: int | None
    """Since when something above the surface belongs to no hand; None: nothing does."""


class PacedTracker:
    """Leaves frames out in which depth confirms the hands. Used from one thread at a time."""

    def __init__(
        self,
        look: Callable[[Frame], Tracked],
        background_mm: Heights,
        valid: Mask,
        focal_px: float,
        max_hands: int,
    ) -> None:
        """`look` finds the hands in a frame; the rest: see `RegionTracker`."""
        self._look = look
        self._max_hands = max_hands
        # What is unknown counts as surface. Every fourth pixel each way is enough.
        lowest_mm = np.where(valid, background_mm - np.float32(HAND_MM), np.float32(0.0))
        self._lowest_mm = lowest_mm[::REDUCE, ::REDUCE].copy()
        px_per_mm = focal_px / max(float(np.median(background_mm[valid])), 1.0)
        self._scale = px_per_mm / REDUCE
        reach = 2 * round(CAME_MM * self._scale) + 1
        self._kernel = np.ones((reach, reach), np.uint8)
        self._px_per_mm = px_per_mm
        self._last: Look | None = None

    def detect(self, frame: Frame) -> Tracked:
        """Return the hands of this frame, or those of the last look where depth confirms them."""
        above = self._above(frame)
        if self._last is not None and not self._is_due(self._last, above, frame.time_us):
            return self._last.tracked
        if np.count_nonzero(above) < LEAST_AREA_MM2 / 2.0 * self._scale**2:
            tracked = Tracked(frame.time_us, ())  # too little for a hand: no model needs to look
        else:
            tracked = self._look(frame)
        near = cv2.dilate(above.view(np.uint8), self._kernel) > 0
        self._last = Look(tracked, near, self._settled(tracked), self._searched_us(tracked, above))
        return tracked

    def _above(self, frame: Frame) -> Mask:
        depth = frame.depth[::REDUCE, ::REDUCE]
        return np.asarray((depth < self._lowest_mm) & (depth > 0))

    def _is_due(self, last: Look, above: Mask, time_us: int) -> bool:
        """Return whether the hands of the last look are old, unsure, or not where they were."""
        hands = last.tracked.hands
        if not hands or last.settled < SETTLED:
            return True
        if not 0 <= time_us - last.tracked.time_us < LOOK_US:
            return True
        if last.searched_us is not None and 0 <= time_us - last.searched_us < SEARCH_US:
            return True
        came = np.count_nonzero(above & ~last.near)
        return bool(came >= CAME_MM2 * self._scale**2)

    def _settled(self, tracked: Tracked) -> int:
        """Return how many looks in a row, this one included, found the same hands."""
        before = self._last.tracked.hands if self._last else ()
        same = len(before) == len(tracked.hands) and all(
            any(self._are_near(hand, other) for other in before) for hand in tracked.hands
        )
        if not same or not self._last or any(hand.confidence < SURE for hand in tracked.hands):
            return 1
        return self._last.settled + 1

    def _searched_us(self, tracked: Tracked, above: Mask) -> int | None:
        hands = tracked.hands
        if len(hands) >= self._max_hands:
            return None
        rest = np.count_nonzero(without_hands(hands, above, self._scale))
        if rest < LEAST_AREA_MM2 * self._scale**2:
            return None
        before = self._last.searched_us if self._last else None
        return tracked.time_us if before is None else before

    def _are_near(self, hand: Hand, other: Hand) -> bool:
        return math.dist(_palm(hand), _palm(other)) < NEAR_MM * self._px_per_mm


def _palm(hand: Hand) -> NDArray[np.float64]:
    return np.asarray(hand.landmarks_px[list(PALM)].mean(axis=0))
