"""All nodes in reach, for the page: watched only while a page shows them."""

from __future__ import annotations

import threading
import time
from typing import Any

from halo_service.app.fleet.view import HEAD, cells, warnings_of
from halo_service.app.fleet.watch import FleetWatch, sources
from halo_service.outputs.settings import ZenohSettings
from halo_service.web.control_page.calls import Call

IDLE_S = 10.0
"""The watch ends when no page has asked for this long; a page asks once a second."""
MOST_ROWS = 200


class NodeCalls:
    """Starts a watch with the first question."""

    def __init__(self, zenoh: ZenohSettings) -> None:
        self._zenoh = zenoh
        self._lock = threading.Lock()
        self._watch: FleetWatch | None = None
        self._asked_s = 0.0
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def table(self) -> dict[str, Call]:
        """Return the call."""
        return {"nodes": Call(self._read, reads=True)}

    def close(self) -> None:
        """End the watch."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def _read(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        with self._lock:
            self._asked_s = time.monotonic()
            if self._watch is None and not self._ended.is_set():
                self._watch = FleetWatch(sources(self._zenoh))
                self._thread = threading.Thread(target=self._end_idle, name="nodes", daemon=True)
                self._thread.start()
            nodes = self._watch.nodes() if self._watch else []
        return {
            "head": HEAD,
            "rows": [cells(each) for each in nodes[:MOST_ROWS]],
            "more": max(0, len(nodes) - MOST_ROWS),
            "warnings": warnings_of(nodes)[:MOST_ROWS],
        }

    def _end_idle(self) -> None:
        """Close the watch when nothing asks for it any more, or at the end."""
        while True:
            ended = self._ended.wait(1.0)
            with self._lock:
                if self._watch is None:
                    return
                if ended or time.monotonic() - self._asked_s > IDLE_S:
                    self._watch.close()
                    self._watch = None
                    return
