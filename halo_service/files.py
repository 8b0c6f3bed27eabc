"""Files that appear when they are complete, or not at all.

Rule: what stands at a path before is the user's. A regular file is replaced by a complete one, a
link is followed, and a pipe or device is written to; none of them is ever removed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


@contextmanager
def appearing(path: Path) -> Iterator[BinaryIO]:
    """Open a file to write; it is moved into place when all went well, else removed.

    Raises OSError where it cannot be written.
    """
    if is_special(path):
        with path.open("wb") as file:
            yield file
        return
    target = followed(path)
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with temporary.open("wb") as file:
            yield file
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def followed(path: Path) -> Path:
    """Return the path at the end of all links, whether something is there or not."""
    return Path(os.path.realpath(path))


def from_home(path: str) -> Path:
    """Return a path with `~` expanded, for what comes from no shell; unknown users stay."""
    return Path(os.path.expanduser(path))  # noqa: PTH111 - Path's own raises for unknown users


def is_special(path: Path) -> bool:
    """Say whether there is a pipe, a device or the like, which can only be written to."""
    return path.exists() and not path.is_file() and not path.is_dir()
