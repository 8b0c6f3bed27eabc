"""The last lines of the log, for the page."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import Any

MOST = 300
LONGEST = 500
"""Characters of a line that are shown."""


class LogLines(logging.Handler):
    """Remembers lines, and passes each new one on."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._lines: deque[dict[str, Any]] = deque(maxlen=MOST)
        self.on_line: Callable[[dict[str, Any]], None] = lambda line: None
        """Called with each new line, from the thread that logs."""

    def emit(self, record: logging.LogRecord) -> None:
        """Note one line."""
        line = {
            "kind": "log",
            "time_s": round(record.created, 1),
            "level": record.levelname.lower(),
            "text": record.getMessage()[:LONGEST],
        }
        self._lines.append(line)
        self.on_line(line)

    def lines(self) -> list[dict[str, Any]]:
        """Return the remembered lines, oldest first."""
        return list(self._lines)
