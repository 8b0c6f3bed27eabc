"""Where a command's text goes: a file that is complete, or the terminal."""

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


@contextmanager
def written(out: str) -> Iterator[TextIO]:
    """Open a text file to write; it appears under its name when all went well.

    `-` is the terminal. Raises `UserError` where it cannot be written, BrokenPipeError where
    the one who reads has had enough.
    """
    if out == STDOUT:
        yield sys.stdout
        return
    if not out:
        raise UserError("the file to write has no name; give it one, or - for the terminal")
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
            f"'{out}' cannot be written ({error.strerror}); choose another place for it"
        ) from error
