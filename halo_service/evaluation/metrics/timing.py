"""When a touch was reported, compared with when it happened.

Rule: on the frames' clock alone. `halo bench` measures what receiving, sensing and sending cost;
here: how many frames the method needs, and how well it dates the contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.touches import Hit


@dataclass(frozen=True, slots=True)
class Timing:
    """One touch that was reported."""

    frames_late: int
    """From the first frame in contact to the frame that reported it; 0: in that very frame."""
    down_ms: float
    """From contact to the frame that reported it."""
    down_ago_error_ms: float
    """Contact as `ago_ms` dates it, minus the true one; negative: dated too early."""
    up_ms: float | None
    """From the contact's end to the frame that reported it; None where none did."""
    up_ago_error_ms: float | None

    @property
    def early(self) -> bool:
        """Whether it was reported before it happened."""
        return self.down_ms < 0.0

    @property
    def late_ms(self) -> float:
        """`down_ms`; an early report counts as 0 ms, so it cannot hide late ones."""
        return max(self.down_ms, 0.0)

    @property
    def late_frames(self) -> int:
        """`frames_late`, likewise."""
        return max(self.frames_late, 0)


def score_timing(hits: Sequence[Hit]) -> tuple[Timing, ...]:
    """Time every touch that was reported."""
    return tuple(_timing(hit) for hit in hits if hit.touch.ended)


def _timing(hit: Hit) -> Timing:
    touch, down = hit.touch, hit.down
    down_ms = (down.time_us - touch.from_us) / 1e3
    up_ms = None if down.up_us is None else (down.up_us - touch.to_us) / 1e3
    return Timing(
        hit.frames_late,
        down_ms,
        down_ms - down.ago_ms,
        up_ms,
        None if up_ms is None else up_ms - down.up_ago_ms,
    )
