"""Prompts, count-down and live signal of the calibration.

A terminal gets a line that is redrawn; a pipe or file gets only the prompts and results.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from halo_calibration.guided.guide import Prompt
from halo_calibration.observe import Observation

BAR = 24
"""Characters of the live signal."""


class Terminal:
    """A `Guide` that prints."""

    def __init__(self, follow: Callable[[Prompt], None] | None) -> None:
        """`follow`: makes the virtual user follow the prompts; None: a person reads them."""
        self._follow = follow
        self._drawn = sys.stderr.isatty()
        self._most = 1.0
        self._map: list[str] = []
        self._lines = 0

    def prompt(self, prompt: Prompt) -> None:
        """Print what to do now."""
        self._wipe()
        self._map = []
        print(f"\n{prompt.words}", file=sys.stderr)
        if self._follow is not None:
            self._follow(prompt)

    def say(self, words: str) -> None:
        """Print a result."""
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
        """Set the map that the next call of `live` draws."""
        self._map = lines

    def _wipe(self) -> None:
        if self._lines:
            up = f"\x1b[{self._lines - 1}A" if self._lines > 1 else ""
            sys.stderr.write(f"\r{up}\x1b[J")
            self._lines = 0
