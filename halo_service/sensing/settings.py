"""The numbers of the sensing that a user may want to change, each with its unit and origin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval

from halo_service.sensing.detections import Fingers

Positive = Annotated[float, Gt(0.0)]
Probability = Annotated[float, Interval(ge=0.01, le=0.99)]


@dataclass(frozen=True, slots=True)
class SensingSettings:
    """`[sensing]` in halo.toml."""

    halo_threshold_mm: Annotated[float, Ge(0.0)] = 0.0
    """A pixel is halo if its depth reads this much farther than the empty table. 0: the value that
    the calibration measured on this surface. The paper uses 8, and 5 to 10 by surface (4.3.1)."""
    hand_threshold_mm: Positive = 4.0
    """A pixel is hand if it is this much nearer than the empty table (chosen: above the noise)."""
    hover_range_mm: Positive = 100.0
    """A fingertip is reported up to this height above the surface."""
    edge_margin_mm: Positive = 20.0
    """A fingertip outside the surface is reported up to this distance from its edge."""
    fingers: Fingers = "index"
    """Which fingers are reported: the index fingers alone, or every extended finger. `all` also
    reports a thumb next to a pointing finger, and each finger costs time."""
    lost_after_ms: Positive = 250.0
    """A finger that is not seen for this time is no longer reported (chosen: a few frames)."""
    down_level: Probability = 0.5
    """A touch begins where the probability of contact rises above this (chosen)."""
    up_level: Probability = 0.1
    """A touch ends where the probability of contact falls below this. It is lower than
    `down_level`, so that a halo that flickers does not end a touch (chosen)."""
    fast_mm_s: Positive = 900.0
    """A finger that moves sideways faster than this cannot begin a touch (as in the paper, 6.2)."""

    def __post_init__(self) -> None:
        """Check the levels against each other. Raises ValueError."""
        if self.up_level >= self.down_level:
            raise ValueError(
                f"'up_level' must be below 'down_level', not {self.up_level:g} and "
                f"{self.down_level:g}"
            )
