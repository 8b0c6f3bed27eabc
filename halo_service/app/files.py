"""Files that appear when they are complete, or not at all."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from halo_service.errors import UserError

STDOUT = "-"


@contextmanager
def written(out: str) -> Iterator[TextIO]:
    """Open a text file to write; it is moved into place when all went well, else removed.

    `-` is the terminal. Raises `UserError` where it cannot be written.
    """
    if out == STDOUT:
        yield sys.stdout
        return
    path = Path(out)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("w", encoding="utf-8", newline="\n") as file:
            yield file
        temporary.replace(path)
    except OSError as error:
        raise UserError(
            f"'{out}' cannot be written ({error.strerror}); choose another place for it"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)
