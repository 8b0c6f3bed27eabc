"""One sentence when nobody plays, and one when somebody does again.

Rule: pure; the caller brings the time and prints.
"""

from __future__ import annotations

from collections.abc import Sequence

from halo_protocol import Event, TouchFrame

PATIENCE_S = 2.0
"""Silence that is worth a word; a service says something at least once a second."""


def waiting(url: str) -> str:
    """What to say while nothing comes."""
    return (
        f"waiting: no frames at {url} yet; is `halo serve` running, and does it send here? "
        "Ctrl-C ends"
    )


class Silence:
    """Notices that no frames come, and that they come again."""

    def __init__(self, url: str, now_s: float) -> None:
        self._url = url
        self._heard_s = now_s
        self.waiting = False
        """Whether it has been silent for so long that it was said."""

    def notice(self, events: Sequence[Event], now_s: float) -> str | None:
        """Take in what a poll brought, at any clock's time; a sentence where there is news."""
        if any(isinstance(event, TouchFrame) for event in events):
            self._heard_s = now_s
            if self.waiting:
                self.waiting = False
                return f"frames come from {self._url}"
        elif not self.waiting and now_s - self._heard_s > PATIENCE_S:
            self.waiting = True
            return waiting(self._url)
        return None
