"""Whether a method knows when it may be wrong: what was told surely, and what was not.

A guest can leave out what is told unsurely, and has nothing to doubt the rest by. So a touch may be
told wrongly, but not surely; and right ones are to be told surely, or the confidence is worth
nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

from halo_service.evaluation.metrics.touches import Down, Touches
from halo_type.layout import KEY_MM

SURE = 0.75
"""Chosen: what is told with at least this confidence is told surely."""
FAR_MM = KEY_MM / 2.0
"""Half a key, chosen: told farther off than that, a touch in the middle of a key is another key's.
The 25 mm within which the paper counts a touch (5.2.1) would let three keys pass."""


@dataclass(frozen=True, slots=True)
class Sureness:
    """Published touches that told a true one where it was, and all others."""

    right_surely: int = 0
    right_unsurely: int = 0
    wrong_surely: int = 0
    wrong_unsurely: int = 0

    def __add__(self, other: Sureness) -> Sureness:
        """Both takes together."""
        return Sureness(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    @property
    def right(self) -> int:
        """How many were right."""
        return self.right_surely + self.right_unsurely

    @property
    def told(self) -> int:
        """How many there were."""
        return self.right + self.wrong_surely + self.wrong_unsurely


def score_sureness(touches: Touches) -> Sureness:
    """Count them; wrong is what was doubled, outside or a ghost, and a hit told FAR_MM off."""
    right = [hit.down for hit in touches.hits if hit.off_mm <= FAR_MM]
    wrong = [hit.down for hit in touches.hits if hit.off_mm > FAR_MM]
    wrong += [*touches.doubled, *touches.outside, *touches.ghosts]
    return Sureness(*_surely(right), *_surely(wrong))


def _surely(downs: Sequence[Down]) -> tuple[int, int]:
    """Return how many were told surely, and how many not; who says nothing warns of nothing."""
    surely = sum(math.isnan(down.confidence) or down.confidence >= SURE for down in downs)
    return surely, len(downs) - surely
