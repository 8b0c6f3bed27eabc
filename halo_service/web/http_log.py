"""What the HTTP library logs of requests that fail.

Rule: any program can send bad requests, so they must not fill the log: those of the sender are
dropped, and an unexpected error is logged once for each place that raises it.
"""

from __future__ import annotations

import logging

from aiohttp.http_exceptions import HttpProcessingError

MOST_PLACES = 64
SENDERS = (HttpProcessingError, ConnectionError)
"""A malformed request, or a client that left."""


class UnexpectedOnly(logging.Filter):
    """Passes each unexpected error once."""

    def __init__(self) -> None:
        super().__init__()
        self._seen: set[tuple[str, int]] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether to log a record."""
        error = record.exc_info[1] if record.exc_info else None
        if error is None or isinstance(error, SENDERS):
            return False
        where = error.__traceback__
        while where is not None and where.tb_next is not None:
            where = where.tb_next
        place = (where.tb_frame.f_code.co_filename, where.tb_lineno) if where else ("", 0)
        if place in self._seen or len(self._seen) >= MOST_PLACES:
            return False
        self._seen.add(place)
        return True


def http_log() -> logging.Logger:
    """Return the logger for one server."""
    log = logging.getLogger(__name__)
    log.filters[:] = [UnexpectedOnly()]
    return log
