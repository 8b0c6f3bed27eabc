"""The calibration's prompts, count-down and live signal in a terminal.

A terminal gets a line that is drawn anew; a pipe or file gets the prompts and results alone.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from halo_calibration.guided.guide import Prompt
from halo_calibration.observe import Observation
from halo_service.profile import StepRecord

BAR = 24
"""Characters of the live signal."""


class Terminal:
    """A `Guide` that prints."""

    def __init__(self, obey: Callable[[Prompt], None] | None) -> None:
        """`obey`: moves the virtual user as the prompts say; None: there is a real one."""
        self._obey = obey
        self._drawn = sys.stderr.isatty()
        self._most = 1.0
        self._map: list[str] = []
        self._lines = 0

    def tell(self, cue: Prompt) -> None:
        """Print what to do now."""
        self._wipe()
        self._map = []
        print(f"\n{cue.words}", file=sys.stderr)
        if self._obey is not None:
            self._obey(cue)

    def say(self, words: str) -> None:
        """Print how something went."""
        self._wipe()
        print(words, file=sys.stderr)

    def live(self, seconds_left: float, measuring: bool, seen: Observation | str | None) -> None:
        """Draw the count-down and the signal, or what else is seen."""
        if not self._drawn:
            return
        phase = "hold    " if measuring else "get ready"
        if seen is None:
            signal = "no finger seen"
        elif isinstance(seen, str):
            signal = seen
        else:
            self._most = max(self._most, seen.raw)
            filled = round(BAR * seen.raw / self._most)
            signal = f"halo {'█' * filled}{'·' * (BAR - filled)} {seen.raw:6.0f}"
        self._wipe()
        lines = [*self._map, f"{phase} {max(seconds_left, 0.0):4.1f} s  {signal}"]
        sys.stderr.write("\n".join(lines))
        sys.stderr.flush()
        self._lines = len(lines)

    def map(self, lines: list[str]) -> None:
        """Keep the map for the next drawing."""
        self._map = lines

    def _wipe(self) -> None:
        if self._lines:
            up = f"\x1b[{self._lines - 1}A" if self._lines > 1 else ""
            sys.stderr.write(f"\r{up}\x1b[J")
            self._lines = 0


def told(step: str, record: StepRecord) -> str:
    """Say in one line how a step went."""
    figures = ", ".join(f"{name} {value:g}" for name, value in record.figures.items())
    note = f" ({record.note})" if record.note else ""
    return f"{step}: {record.quality}. {figures}{note}"
