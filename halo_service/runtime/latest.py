"""The only hand-off between threads: the newest value, and how many older ones it replaced."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

T = TypeVar("T")


class Latest(Generic[T]):
    """Holds at most one value: a late reader gets the newest, never a backlog."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._value: T | None = None
        self._fresh = False
        self.dropped = 0
        """Values that were replaced before they were taken."""

    def put(self, value: T) -> None:
        """Offer a value; it replaces one that was not taken yet."""
        with self._changed:
            self.dropped += self._fresh
            self._value, self._fresh = value, True
            self._changed.notify()

    def clear(self) -> None:
        """Forget the newest value."""
        with self._changed:
            self._value, self._fresh = None, False

    def take(self, timeout_s: float) -> T | None:
        """Wait for a value that was not taken before; None if none comes in time."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._fresh, timeout_s):
                return None
            self._fresh = False
            return self._value

    def peek(self) -> T | None:
        """Return the newest value without taking it, at once."""
        with self._changed:
            return self._value
