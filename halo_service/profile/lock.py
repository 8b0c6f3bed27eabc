"""One writer at a time, over processes; the system lets go for a writer that is killed."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

NAME = ".lock"
WAIT_S = 10.0
"""Saving takes a fraction of a second; who holds on for longer hangs."""
AGAIN_S = 0.02


class Busy(OSError):  # noqa: N818 - what the folder is
    """Another process holds the lock, and goes on doing so."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder's lock; raises `Busy` where another process keeps it."""
    handle = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        until = time.monotonic() + WAIT_S
        while not _taken(handle):
            if time.monotonic() > until:
                raise Busy("another program is writing it")
            time.sleep(AGAIN_S)
        yield
    finally:
        os.close(handle)


if sys.platform == "win32":
    import msvcrt

    def _taken(handle: int) -> bool:
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _taken(handle: int) -> bool:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
