"""A pseudo terminal, to see what a program shows a person and not a pipe."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

needs_terminal = pytest.mark.skipif(sys.platform == "win32", reason="pseudo terminals are POSIX")


@contextmanager
def terminal() -> Iterator[tuple[int, int]]:
    """Open a pseudo terminal: the end to read from, and the program's end."""
    ours, theirs = os.openpty()
    try:
        yield ours, theirs
    finally:
        os.close(ours)


def shown(ours: int) -> str:
    """Read all that was shown, once the program's end is closed."""
    parts = []
    while True:
        try:
            parts.append(os.read(ours, 4096))
        except OSError:  # Linux reports the end of a pseudo terminal as an error
            break
        if not parts[-1]:
            break
    return b"".join(parts).decode()
