"""One sentence when no frames arrive, and one when they arrive again.

Rule: pure; the caller passes the time and prints.
"""

from __future__ import annotations

from collections.abc import Sequence

from halo_protocol import Event, Lost, TouchFrame

REPORT_AFTER_S = 2.0
"""Silence that is reported; a service sends at least once a second."""


def waiting(url: str) -> str:
    """The sentence to print while no frames arrive."""
    return (
        f"waiting: no frames at {url} yet; is `halo serve` running, and does it send here? "
        "Its first start measures the table for up to 20 s. Ctrl-C ends"
    )


class Silence:
    """Detects that frames stop and that they start again."""

    def __init__(self, url: str, now_s: float) -> None:
        self._url = url
        self._last_frame_s = now_s
        self.waiting = False
        """Whether the silence was reported."""

    def notice(self, events: Sequence[Event], now_s: float) -> str | None:
        """Process the events of a poll; returns a sentence when the state changes."""
        # The last frame of a lost service is the receiver's own, to end the touches.
        lost = any(isinstance(event, Lost) for event in events)
        if not lost and any(isinstance(event, TouchFrame) for event in events):
            self._last_frame_s = now_s
            if self.waiting:
                self.waiting = False
                return f"frames come from {self._url}"
        elif not self.waiting and now_s - self._last_frame_s > REPORT_AFTER_S:
            self.waiting = True
            return waiting(self._url)
        return None
