"""How log lines look: for a person, for journald, or as JSON. Standard library alone."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Mapping
from datetime import UTC, datetime

PRIORITIES = {"CRITICAL": 2, "ERROR": 3, "WARNING": 4, "INFO": 6, "DEBUG": 7}
"""Of syslog; journald reads them in front of a line."""
OURS = ("halo_service", "halo_calibration")


class _Json(logging.Formatter):
    """One JSON object a line."""

    def format(self, record: logging.LogRecord) -> str:
        """Return time, level, part and message, and the traceback of an unexpected error."""
        time = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        line = {
            "time": time.replace("+00:00", "Z"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return json.dumps(line)


class _Journal(logging.Formatter):
    """The priority in front of each line; journald adds time and name of the unit."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the message, with the priority in front of each of its lines."""
        mark = f"<{PRIORITIES.get(record.levelname, 6)}>"
        return "\n".join(mark + line for line in super().format(record).splitlines())


def formatter(as_json: bool, environment: Mapping[str, str] = os.environ) -> logging.Formatter:
    """Return how to write log lines. systemd sets JOURNAL_STREAM where journald reads stderr."""
    if as_json:
        return _Json()
    if "JOURNAL_STREAM" in environment and not sys.stderr.isatty():
        return _Journal()
    return logging.Formatter("halo: %(message)s")


def set_up_logging(level: int, as_json: bool = False) -> None:
    """Let our own modules log at this level, and libraries only their warnings."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(formatter(as_json))
    logging.basicConfig(handlers=[handler])
    for name in OURS:
        logging.getLogger(name).setLevel(level)
