"""Datagrams that a thread receives and another one reads.

Rule: bounded. When a client is busy, the oldest datagrams are dropped; the next frame replaces
them.
"""

from __future__ import annotations

import threading
from collections import deque

RING = 256
"""Datagrams that wait at most: some seconds of one service."""


class Ring:
    """The last `RING` datagrams, each with its sender."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[bytes, str]] = deque(maxlen=RING)
        self._arrived = threading.Condition()

    def put(self, datagram: bytes, sender: str) -> None:
        """Add a datagram; never waits for the reader."""
        with self._arrived:
            self._waiting.append((datagram, sender))
            self._arrived.notify()

    def get(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The oldest datagram and its sender, or None after the timeout."""
        with self._arrived:
            if not self._waiting:
                self._arrived.wait(timeout_s)
            return self._waiting.popleft() if self._waiting else None
