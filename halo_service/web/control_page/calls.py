"""What the page can ask the service to do: a table that the app fills."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

LARGEST_JSON = 64 << 10
LARGEST_FILE = 32 << 20


@dataclass(frozen=True, slots=True)
class Call:
    """One call. It runs in a thread, and may take seconds; `UserError` is its way to refuse."""

    run: Callable[[Any], Any]
    """Gets the JSON value of the request, or its bytes; returns a JSON value, or bytes."""
    reads: bool = False
    """A viewer may call it too."""
    takes_file: bool = False
    """Its request is a file."""

    @property
    def largest(self) -> int:
        """Bytes of a request."""
        return LARGEST_FILE if self.takes_file else LARGEST_JSON

    def value(self, body: bytes) -> Any:
        """Return what `run` gets. Raises ValueError for a body that is not JSON."""
        if self.takes_file:
            return body
        try:
            value = json.loads(body)
        except RecursionError as error:
            raise ValueError("too deep") from error
        if not isinstance(value, dict):
            raise ValueError("not an object")
        return value
