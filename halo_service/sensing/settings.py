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
    """Excess depth from which a pixel is halo (the paper's is 8, 5 to 10 by placement and material:
    4.3.1); 0: what the calibration measured on this surface."""
    hand_threshold_mm: Positive = 4.0
    """How much nearer than the background a pixel must be to be hand (chosen: above the noise)."""
    hover_range_mm: Positive = 100.0
    """Up to this height above the surface a fingertip is a pointer."""
    edge_margin_mm: Positive = 20.0
    """A pointer may leave the surface by this much."""
    fingers: Fingers = "index"
    """Which are pointers: the index fingers alone, or every extended finger (chosen: a thumb beside
    a pointing index finger is rarely meant, and costs as much time)."""
    lost_after_ms: Positive = 250.0
    """A finger that the depth has not shown for so long is gone (chosen: a few frames)."""
    down_level: Probability = 0.5
    """A touch begins where its probability, seen in one frame, passes this (chosen)."""
    up_level: Probability = 0.1
    """A touch ends where its probability falls below this (chosen: hysteresis against a halo that
    flickers)."""
    fast_mm_s: Positive = 900.0
    """A finger moving sideways faster than this cannot come down (paper 6.2 filters by speed)."""

    def __post_init__(self) -> None:
        """Check the levels against each other. Raises ValueError."""
        if self.up_level >= self.down_level:
            raise ValueError(
                f"'up_level' must be below 'down_level', not {self.up_level:g} and "
                f"{self.down_level:g}"
            )
