"""Whether a method knows when it may be wrong: touches reported with high and low confidence.

A client can ignore touches with low confidence, but must trust the others. So a wrong
touch should have low confidence, and a right one high confidence, or the confidence is worthless.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.touches import Down, Touches
from halo_type.layout import KEY_MM

HIGH_CONFIDENCE = 0.75
"""Chosen: confidence is high from here on."""
FAR_MM = KEY_MM / 2.0
"""Half a key, chosen: a touch in the middle of a key that is reported farther off is another key's.
The 25 mm within which the paper counts a touch (5.2.1) would let three keys pass."""


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
    right = [hit.down for hit in touches.hits if hit.off_mm <= FAR_MM]
    wrong = [hit.down for hit in touches.hits if hit.off_mm > FAR_MM]
    wrong += [*touches.doubled, *touches.outside, *touches.ghosts]
    return Confidence(*_high_and_low(right), *_high_and_low(wrong))


def _high_and_low(downs: Sequence[Down]) -> tuple[int, int]:
    """Count downs with high and with low confidence; without any confidence counts as high."""
    high = sum(math.isnan(down.confidence) or down.confidence >= HIGH_CONFIDENCE for down in downs)
    return high, len(downs) - high
