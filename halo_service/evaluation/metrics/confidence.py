"""Whether a method knows when it may be wrong: touches reported with high and low confidence.

A client can ignore touches with low confidence, but must trust the others. So a wrong
touch should have low confidence, and a right one high confidence, or the confidence is worthless.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from halo_service.evaluation.metrics.touches import Down, Touches
from halo_type.layout import KEY_MM

HIGH_CONFIDENCE = 0.75
"""Chosen: confidence is high from here on."""
FAR_MM = KEY_MM / 2.0
"""Half a key, chosen: a touch in the middle of a key that is reported farther off is another key's.
The 25 mm within which the paper counts a touch (5.2.1) would let three keys pass."""


BINS = (0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Ends of the bins of a reliability table (chosen: touches begin at a confidence near 0.5)."""


@dataclass(frozen=True, slots=True)
class Bin:
    """The published touches with a confidence in a range: how many of them were right."""

    least: float
    most: float
    reported: int
    right: int
    confidence: float
    """Mean of theirs; nan without any."""

    @property
    def share(self) -> float:
        """Share that was right; nan without any."""
        return self.right / self.reported if self.reported else math.nan


@dataclass(frozen=True, slots=True)
class Confidence:
    """Counts of published touches: right or wrong, with high or low confidence."""

    right_high: int = 0
    right_low: int = 0
    wrong_high: int = 0
    wrong_low: int = 0

    @property
    def right(self) -> int:
        """All right touches."""
        return self.right_high + self.right_low

    @property
    def reported(self) -> int:
        """All published touches."""
        return self.right + self.wrong_high + self.wrong_low


def score_confidence(touches: Touches) -> Confidence:
    """Count them. Wrong: doubled, outside, a ghost, or a hit farther than FAR_MM off."""
    right, wrong = _judged(touches)
    return Confidence(*_high_and_low(right), *_high_and_low(wrong))


def reliability(touches: Touches) -> tuple[Bin, ...]:
    """Return how many were right in each bin of confidence; downs without one are left out.

    A method is calibrated where each bin's share is its confidence.
    """
    found: list[list[tuple[float, bool]]] = [[] for _ in BINS[1:]]
    for downs, right in zip(_judged(touches), (True, False), strict=True):
        for confidence in (down.confidence for down in downs):
            if not math.isnan(confidence):
                index = min(bisect_right(BINS, confidence), len(found)) - 1
                found[index].append((confidence, right))
    return tuple(
        Bin(
            *ends,
            len(each),
            sum(right for _, right in each),
            sum(confidence for confidence, _ in each) / len(each) if each else math.nan,
        )
        for ends, each in zip(pairwise(BINS), found, strict=True)
    )


def _judged(touches: Touches) -> tuple[list[Down], list[Down]]:
    """Return the published touches that were right, and those that were wrong."""
    right = [hit.down for hit in touches.hits if hit.off_mm <= FAR_MM]
    wrong = [hit.down for hit in touches.hits if hit.off_mm > FAR_MM]
    return right, [*wrong, *touches.doubled, *touches.outside, *touches.ghosts]


def _high_and_low(downs: Sequence[Down]) -> tuple[int, int]:
    """Count downs with high and with low confidence; without any confidence counts as high."""
    high = sum(math.isnan(down.confidence) or down.confidence >= HIGH_CONFIDENCE for down in downs)
    return high, len(downs) - high
