"""Which fingertips the hand tracker shows: those of extended fingers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Finger, Hand, Side, Tracked

Pixel = tuple[float, float]

INDEX_PIP, INDEX_DISTAL, INDEX_TIP, WRIST = 6, 7, 8, 0
"""MediaPipe's landmark numbers."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """An extended index finger in the tracker's frame."""

    time_us: int
    side: Side
    finger: Finger
    tip_px: Pixel
    distal_px: Pixel
    confidence: float


def sightings(tracked: Tracked | None) -> tuple[Sighting, ...]:
    """Return the extended index fingers of the tracked hands."""
    if tracked is None:
        return ()
    return tuple(
        Sighting(
            tracked.time_us,
            hand.side,
            Finger.INDEX,
            _pixel(hand.landmarks_px[INDEX_TIP]),
            _pixel(hand.landmarks_px[INDEX_DISTAL]),
            hand.confidence,
        )
        for hand in tracked.hands
        if _extended(hand)
    )


def _extended(hand: Hand) -> bool:
    """Say whether the index finger points: the tip is farther from the wrist than the knuckle."""
    wrist, knuckle, tip = (hand.landmarks_px[i] for i in (WRIST, INDEX_PIP, INDEX_TIP))
    return bool(np.linalg.norm(tip - wrist) > np.linalg.norm(knuckle - wrist))


def _pixel(point: NDArray[np.float64]) -> Pixel:
    return float(point[0]), float(point[1])
