"""The numbers of the sensing that a user may want to change, each with its unit and origin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt

from halo_service.sensing.detections import Fingers

Positive = Annotated[float, Gt(0.0)]


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
    down_departure: Positive = 0.2
    """How far the level (0 subtle, 1 touch) departs from its baseline at a touch (chosen: several
    times the level's noise, and what a flat finger's weaker halo still reaches)."""
    down_level: Positive = 0.2
    """Least level of a touch, whatever the baseline (chosen: a flat finger's halo is weaker)."""
    down_rise_per_s: Positive = 1.5
    """Least rise of the level at a sharp touch, 1/s (chosen: 0.05 a frame, a slow finger's)."""
    sure_level: Positive = 0.8
    """From this level on a touch need not be sharp (chosen: a soft landing ends above it)."""
    up_level: Positive = 0.1
    """Below this level a touch ends (chosen: hysteresis against a halo that flickers)."""
    baseline_time_ms: Positive = 400.0
    """Time constant of the adaptive baseline (chosen: slower than a tap, faster than drift)."""
    fast_mm_s: Positive = 900.0
    """A finger moving sideways faster than this cannot come down (paper 6.2 filters by speed)."""

    def __post_init__(self) -> None:
        """Check the levels against each other. Raises ValueError."""
        if self.up_level >= self.down_level:
            raise ValueError(
                f"'up_level' must be below 'down_level', not {self.up_level:g} and "
                f"{self.down_level:g}"
            )
        if self.down_level > self.sure_level:
            raise ValueError(
                f"'down_level' must be at most 'sure_level', not {self.down_level:g} and "
                f"{self.sure_level:g}"
            )
