"""Writes the text of a command to a file, which appears when complete, or to stdout."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from halo_service.errors import UserError
from halo_service.files import appearing

STDOUT = "-"


def refuse_existing(out: Path, *, force: bool) -> None:
    """Refuse to replace a file of the user, unless `force`. Raises `UserError`."""
    if out.is_dir():
        raise UserError(f"{out} is a folder; name a file")
    if out.is_file() and not force:
        raise UserError(f"{out} exists already; choose another name, or add --force to replace it")


@contextmanager
def written(out: str) -> Iterator[TextIO]:
    """Open a text file to write; it appears under its name when the block ends without an error.

    `-` is stdout. Raises `UserError` if it cannot be written, BrokenPipeError if the program that
    reads the output has ended.
    """
    if out == STDOUT:
        yield sys.stdout
        return
    if not out:
        raise UserError("the file to write has no name; give a name, or - for stdout")
    try:
        with (
            appearing(Path(out)) as file,
            io.TextIOWrapper(file, encoding="utf-8", newline="\n") as text,
        ):
            yield text
    except BrokenPipeError:
        raise
    except OSError as error:
        raise UserError(
            f"'{out}' cannot be written ({error.strerror}); choose another path"
        ) from error
