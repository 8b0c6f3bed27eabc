"""A `Guide` that shows prompts, progress and signal on the page."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Any

from halo_calibration.guided.guide import Prompt
from halo_calibration.observe import Observation
from halo_service.errors import UserError

EVERY_S = 0.1
"""How often the page gets the live signal."""
MOST_SAID = 40


class Stopped(UserError):  # noqa: N818 - what happened, as the page says it
    """The user stopped the step."""


class PageGuide:
    """One step's prompts and progress; used from the step's thread alone."""

    def __init__(
        self,
        show: Callable[[dict[str, Any]], None],
        stopped: threading.Event,
        follow: Callable[[Prompt], None] | None = None,
    ) -> None:
        """`show`: gets the state whenever it changed; `stopped`: set when the step shall end;
        `follow`: makes the virtual user follow the prompts."""
        self._show, self._stopped, self._follow = show, stopped, follow
        self._state: dict[str, Any] = {
            "prompt": "", "name": "", "phase": "", "left_s": 0.0, "share": 0.0, "seen": "",
            "signal": None, "most": 1.0, "map": [], "said": [],
        }  # fmt: skip
        self._total_s = 0.0
        self._shown_s = float("-inf")

    def prompt(self, prompt: Prompt) -> None:
        """Show what to do now."""
        self.check()
        self._state |= {"prompt": prompt.words, "name": prompt.name, "phase": "", "map": []}
        self._total_s = 0.0
        self._publish()
        if self._follow is not None:
            self._follow(prompt)

    def say(self, words: str) -> None:
        """Show a result."""
        self.check()
        self._state["said"] = [*self._state["said"], words][-MOST_SAID:]
        self._publish()

    def live(self, seconds_left: float, measuring: bool, seen: Observation | str | None) -> None:
        """Show the count-down, and the signal or what else is seen."""
        self.check()
        phase = "measure" if measuring else "ready"
        if phase != self._state["phase"]:
            self._total_s = seconds_left
        self._total_s = max(self._total_s, seconds_left, 0.1)
        signal = seen.raw if isinstance(seen, Observation) and math.isfinite(seen.raw) else None
        words = seen if isinstance(seen, str) else "" if seen is not None else "no finger seen"
        self._state |= {
            "phase": phase,
            "left_s": round(max(seconds_left, 0.0), 1),
            "share": round(1.0 - max(seconds_left, 0.0) / self._total_s, 3),
            "seen": words,
            "signal": None if signal is None else round(signal, 1),
            "most": max(self._state["most"], signal or 0.0),
        }
        if time.monotonic() - self._shown_s >= EVERY_S:
            self._publish()

    def explain(self, words: str) -> None:
        """Show what to do, without a prompt that a virtual user follows."""
        self._state |= {"prompt": words, "phase": ""}
        self._publish()

    def count(self, done: int, total: int, words: str) -> None:
        """Show how much is done, for a step without a count-down."""
        self.check()
        self._state |= {"phase": "count", "share": round(done / max(total, 1), 3), "seen": words}
        if time.monotonic() - self._shown_s >= EVERY_S:
            self._publish()

    def map(self, lines: list[str]) -> None:
        """Set what of the surface is covered; `live` shows it."""
        self._state["map"] = lines

    def _publish(self) -> None:
        self._shown_s = time.monotonic()
        self._show(dict(self._state))

    def check(self) -> None:
        """Raise `Stopped` where the user stopped the step."""
        if self._stopped.is_set():
            raise Stopped("stopped")
