"""Unexpected errors that must not end the service: each kind is logged once, with its traceback."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from halo_service.errors import UserError

log = logging.getLogger(__name__)

MOST_KINDS = 64
"""Kinds that are logged in one session: an error on every frame must not fill a disk."""


class ErrorLog:
    """Remembers which kinds were logged. A kind: the part that failed, the error, the line."""

    def __init__(self) -> None:
        self._seen: set[tuple[str, str, str, int]] = set()

    def report(self, part: str, error: Exception) -> str:
        """Log an error unless its kind was logged before; return it in one line."""
        summary = f"{part} failed: {type(error).__name__}: {error}"
        kind = (part, type(error).__name__, *_raised_at(error))
        if kind not in self._seen and len(self._seen) < MOST_KINDS:
            self._seen.add(kind)
            log.error("%s; this kind of error is logged once", summary, exc_info=error)
        return summary

    @contextmanager
    def guard(self, part: str) -> Iterator[None]:
        """Log what goes wrong in a block and go on after it; `UserError` passes."""
        try:
            yield
        except UserError:
            raise
        except Exception as error:
            self.report(part, error)


def _raised_at(error: Exception) -> tuple[str, int]:
    """Return file and line that raised."""
    where = error.__traceback__
    if where is None:
        return "", 0
    while where.tb_next is not None:
        where = where.tb_next
    return where.tb_frame.f_code.co_filename, where.tb_lineno
