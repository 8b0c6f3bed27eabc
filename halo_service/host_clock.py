"""Unix time that never jumps, for everything that paces or dates frames.

Rule: monotonic time plus an offset. When the host's clock is set, the offset follows slowly, so
time in frames neither goes back nor leaps; how far it is off is reported in `health`.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

log = logging.getLogger(__name__)

SLEW = 500e-6
"""Correction per time: ten times the drift of a bad crystal, and 0.02 ms per frame at 30 Hz."""
JUMP_NS = 100_000_000
"""A change of the host's clock by more than that at once: it was set."""


def _monotonic_ns() -> int:
    """Read a clock that only goes forward, and also while the machine sleeps where possible."""
    boot_time = getattr(time, "CLOCK_BOOTTIME", None)  # Linux; elsewhere monotonic() does so
    return time.monotonic_ns() if boot_time is None else time.clock_gettime_ns(boot_time)


class HostClock:
    """One per process; may be read by any thread."""

    def __init__(
        self,
        unix_ns: Callable[[], int] = time.time_ns,
        monotonic_ns: Callable[[], int] = _monotonic_ns,
    ) -> None:
        self._unix_ns, self._monotonic_ns = unix_ns, monotonic_ns
        self._lock = threading.Lock()
        self._read_ns = monotonic_ns()
        self._difference_ns = unix_ns() - self._read_ns
        """The host's Unix time minus monotonic time, when last read."""
        self._offset_ns = float(self._difference_ns)
        """This clock's Unix time minus monotonic time."""
        self.jumps = 0
        """How often the host's clock was set."""

    def unix_us(self) -> int:
        """Return Unix time in microseconds; it rises by 0.9995 to 1.0005 per second."""
        with self._lock:
            now_ns = self._monotonic_ns()
            self._follow(now_ns, self._unix_ns() - now_ns)
            return (now_ns + round(self._offset_ns)) // 1000

    def check(self) -> tuple[int, float]:
        """Read the clocks; return `jumps` and `error_ms` as of now."""
        self.unix_us()
        return self.jumps, self.error_ms

    @property
    def error_ms(self) -> float:
        """The host's Unix time minus this clock's, as of the last read."""
        return (self._difference_ns - self._offset_ns) / 1e6

    def _follow(self, now_ns: int, difference_ns: int) -> None:
        set_by_ns = difference_ns - self._difference_ns
        if abs(set_by_ns) > JUMP_NS:
            self.jumps += 1
            log.warning(
                "clock: the host's clock was set by %+.1f s; the time of frames follows slowly",
                set_by_ns / 1e9,
            )
        self._difference_ns = difference_ns
        most_ns = SLEW * (now_ns - self._read_ns)
        self._read_ns = now_ns
        self._offset_ns += max(-most_ns, min(most_ns, difference_ns - self._offset_ns))


CLOCK = HostClock()
"""This process's clock."""
