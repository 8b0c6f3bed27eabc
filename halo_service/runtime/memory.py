"""The memory of this process, and a watch for a leak."""

from __future__ import annotations

import os
from pathlib import Path

STATM = Path("/proc/self/statm")
UNKNOWN = -1
SETTLE_S = 30.0
"""Libraries and caches are loaded by then."""
LEAK_MB = 400
"""Growth that is a leak: a service grows by less than 50 MB in an hour."""


def memory_mb() -> int:
    """Return the resident memory of this process in MB; `UNKNOWN` where only Linux would know."""
    try:
        pages = int(STATM.read_text().split()[1])
    except OSError:
        return UNKNOWN
    return round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6)


class MemoryWatch:
    """Notices that memory grows and does not stop. Time is an argument."""

    def __init__(self) -> None:
        self._since_s: float | None = None
        self._usual_mb = UNKNOWN

    def leaks(self, now_s: float, used_mb: int) -> bool:
        """Say once that memory has grown by `LEAK_MB`; what comes after is compared with then."""
        if self._since_s is None:
            self._since_s = now_s
        if now_s - self._since_s < SETTLE_S or used_mb == UNKNOWN:
            return False
        if self._usual_mb == UNKNOWN:
            self._usual_mb = used_mb
        self._usual_mb = min(self._usual_mb, used_mb)
        if used_mb - self._usual_mb < LEAK_MB:
            return False
        self._since_s, self._usual_mb = now_s, UNKNOWN
        return True
