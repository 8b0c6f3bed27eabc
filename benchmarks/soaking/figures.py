"""What was seen, except by the client."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

RECOVERED_S = 1.5
"""Wanted: from the end of a fault to the next touch."""
UNREPORTED = -1.0
"""For what `health` does not report, because frames go on."""


@dataclass(frozen=True)
class Row:
    """What a fault did once."""

    fault: str
    reported_s: float | None
    """Until `health` reported it; None: never."""
    back_s: float | None
    """Until touches came back after its end; None: never."""

    @property
    def good(self) -> bool:
        """Whether it was reported, and touches were back in time."""
        back_s = math.inf if self.back_s is None else self.back_s
        return self.reported_s is not None and back_s <= RECOVERED_S


@dataclass
class Figures:
    """Of all faults, and of the service."""

    rows: list[Row] = field(default_factory=list)
    lost: int = 0
    """Touches between faults that did not arrive."""
    restarts: int = 0
    memory_mb: tuple[float, float] = (0.0, 0.0)
    """Of the service, at the beginning and at the end."""
    handles: tuple[int, int] = (0, 0)
    """Its open files."""
    ended_empty: bool = False
    """Whether no touch went on after its end."""


def duration(value: float | None) -> str:
    """Return seconds as text."""
    if value is None:
        return "never"
    return "-" if value == UNREPORTED else f"{value:.2f} s"
