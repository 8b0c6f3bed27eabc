"""Files that appear when they are complete, or not at all.

Rule: a regular file is replaced by a complete one; a pipe or device is written to.
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

    Raises `OSError` where it cannot be written.
    """
    if path.exists() and not path.is_file():  # also a folder, which gives the right error
        with path.open("wb") as file:
            yield file
        return
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with _open(temporary, path) as file:
            yield file
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def _open(temporary: Path, path: Path) -> BinaryIO:
    try:
        return temporary.open("wb")
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from error
