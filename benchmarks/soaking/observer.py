"""Waits for what a fault does, and notes it."""

from __future__ import annotations

import math
import statistics
import time

from halo_protocol import Health

from .faults import Shows
from .figures import Figures, Row, duration
from .running import Running

REPORTED_S = 12.0
"""Longest wait for a report of a fault: a silent camera is lost after 5 s, a profile does not fit
after 3 checks."""
QUIET_S = 3.0
"""Between two faults: touches are counted."""
TAPS_HZ = 2.0


class Observer:
    """Sees what the client receives, and notes what each fault does."""

    def __init__(self, running: Running) -> None:
        self.running, self.seen = running, running.seen
        self.figures = Figures()
        self._began_s = time.monotonic()
        self._used: list[tuple[float, float, int]] = []
        """Seconds since the start, memory in MB, open files; in each pause between two faults."""

    def note(self, fault: str, reported_s: float | None, back_s: float | None) -> None:
        """Note what a fault did; print at once where it is not as wanted."""
        row = Row(fault, reported_s, back_s)
        self.figures.rows.append(row)
        if not row.good:
            said = f"reported {duration(reported_s)}, touch {duration(back_s)}"
            print(f"after {self.after_s():.0f} s: {fault}: {said}", flush=True)

    def reported(self, before: Health | None, began_s: float, shows: Shows) -> float | None:
        """Wait until `health` shows a fault; return how long that took, None if it never did."""

        def reported() -> bool:
            return before is not None and shows(before, self.seen.health or before)

        self.running.watch(REPORTED_S, reported)
        return time.monotonic() - began_s if reported() else None

    def recovery(self) -> float | None:
        """Wait for the next touch; return how long that took, None if none came."""
        ended_s = time.monotonic()
        self.running.watch(10.0, lambda: self.seen.down_s > ended_s)
        return self.seen.down_s - ended_s if self.seen.down_s > ended_s else None

    def quiet(self) -> None:
        """Count the touches of a while without a fault."""
        before, began_s = self.seen.downs, time.monotonic()
        self.running.watch(QUIET_S)
        made = int((time.monotonic() - began_s) * TAPS_HZ) - 1  # one may be cut at each end
        self.figures.lost += max(made - (self.seen.downs - before), 0)
        self._used.append((self.after_s(), *self.running.usage()))

    def compare(self, warm_s: float) -> None:
        """Compare memory and open files: medians of the first and the last quarter once it is warm.

        Single values differ by a profile or two, which are replaced again and again.
        """
        warm = [each for each in self._used if each[0] > warm_s] or self._used[-1:]
        part = math.ceil(len(warm) / 4)
        ends = (warm[:part], warm[-part:])
        first, last = (statistics.median(each[1] for each in end) for end in ends)
        self.figures.memory_mb = (first, last)
        first, last = (statistics.median(each[2] for each in end) for end in ends)
        self.figures.handles = (round(first), round(last))

    def after_s(self) -> float:
        """Return the seconds since the start."""
        return time.monotonic() - self._began_s
