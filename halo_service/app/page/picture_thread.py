"""Encodes pictures beside the frames: only those that an open page waits for.

Rule: the live loop only notes its newest frame. This thread takes a core when the frames leave it.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from halo_service.app.page.pictures import Look, picture
from halo_service.runtime.error_log import ErrorLog
from halo_service.runtime.tracker_thread import yield_the_core
from halo_service.web.control_page.server import PageServer

log = logging.getLogger(__name__)

EVERY_S = 0.15
"""Time between two pictures of a kind: enough to follow a hand."""


class PictureThread:
    """Runs until it is closed."""

    def __init__(self, server: PageServer, newest: Callable[[], Look | None]) -> None:
        """`newest`: the newest frame; called in this thread."""
        self._server, self._newest = server, newest
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pictures", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        yield_the_core()
        errors = ErrorLog()
        last: Look | None = None
        while not self._ended.wait(EVERY_S):
            look = self._newest()
            if look is None or look is last:
                continue
            for kind in sorted(self._server.wanted()):
                with errors.guard(f"picture {kind}"):
                    self._send(kind, look)
                last = look

    def _send(self, kind: str, look: Look) -> None:
        data = picture(kind, look)
        if data is not None:
            self._server.post(lambda: self._server.send_picture(kind, data))
