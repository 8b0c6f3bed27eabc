"""Numbers that TUIO clients need: they drop frames, or freeze, when a number goes back.

Their counters are signed 32-bit numbers. They start at Unix time in steps of 10 ms, so that a
restarted service is ahead of what it sent before.
"""

from __future__ import annotations

MODULUS = 2**31
STEP_US = 10_000
MM_PER_UNIT = 100.0
"""A height of 100 mm is 1.0 in TUIO's z and -1.0 in its press."""


class TuioIds:
    """Frame numbers and session ids of one stream."""

    def __init__(self) -> None:
        self._base: int | None = None
        self._frame = 0

    def next_frame(self, time_us: int) -> int:
        """Return the number of the next bundle; the first comes from the frame's time."""
        if self._base is None:
            self._base = time_us // STEP_US % MODULUS
            self._frame = self._base
        else:
            self._frame = (self._frame + 1) % MODULUS
        return self._frame

    def of(self, pointer_id: int) -> int:
        """Return a session id that no earlier run of the service has used for another finger."""
        return ((self._base or 0) + pointer_id) % MODULUS


def clamped(value: float) -> float:
    """TUIO positions are 0 to 1."""
    return min(max(value, 0.0), 1.0)
