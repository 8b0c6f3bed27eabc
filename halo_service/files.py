"""Files that appear when they are complete, or not at all.

Rule: an existing file is the user's. A regular file is replaced by a complete one, a
link is followed, and a pipe or device is written to; none of them is ever removed.
"""

from __future__ import annotations

import codecs
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from filelock import FileLock
from platformdirs import user_cache_path, user_data_path

from halo_service.errors import UserError


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


def cache_folder() -> Path:
    """Return where this user's downloads and simulated recordings are. Raises `UserError`."""
    return _user_folder(user_cache_path, "XDG_CACHE_HOME")


def data_folder() -> Path:
    """Return where this user's profiles are. Raises `UserError`."""
    return _user_folder(user_data_path, "XDG_DATA_HOME")


def _user_folder(find: Callable[..., Path], variable: str) -> Path:
    """Return a folder of the user; containers and services run users that have no home."""
    try:
        path = find("halo-service", appauthor=False)
    except RuntimeError:
        path = Path()
    home = os.environ.get("HOME", "/") if os.name == "posix" else "/"
    if not path.is_absolute() or not (home.startswith("/") or os.environ.get(variable)):
        raise UserError(
            f"this user has no home folder; set HOME or {variable} to a folder that can be written"
        )
    return path


def is_special(path: Path) -> bool:
    """Say whether there is a pipe, a device or the like, which can only be written to."""
    return path.exists() and not path.is_file() and not path.is_dir()


LOCK_WAIT_S = 10.0
"""Saving takes a fraction of a second; a program that holds a lock longer hangs."""


def folder_lock(folder: Path) -> FileLock:
    """Return a folder's lock for `with`: one writer at a time, over processes.

    The system releases it when its process is killed. Raises `filelock.Timeout`, an OSError,
    where another process holds it for `LOCK_WAIT_S`.
    """
    return FileLock(folder / ".lock", timeout=LOCK_WAIT_S, poll_interval=0.02)


BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""What Windows editors write in front of a text, and the encoding that it means."""


def read_text(path: Path) -> str:
    """Read a text in UTF-8, or in UTF-16 if it starts with a byte-order mark.

    Raises OSError where it cannot be read, ValueError with a sentence for another encoding.
    """
    content = path.read_bytes()
    encoding = next(
        (name for mark, name in BYTE_ORDER_MARKS.items() if content.startswith(mark)), "utf-8"
    )
    if encoding == "utf-8" and b"\0" in content:
        raise ValueError("it seems to be UTF-16 without a byte-order mark; save it as UTF-8")
    try:
        return content.decode(encoding).replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"it is not {error.encoding.upper()} text (byte {error.start}); save it as UTF-8"
        ) from error
