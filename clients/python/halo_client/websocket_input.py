"""Datagrams from the WebSocket of a service.

Rule: a thread connects, receives and connects again, so that a service may start later or
restart. A reason why it cannot connect is logged once.
"""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import threading
from typing import Any

from halo_client.errors import ClientError
from halo_client.ring import Ring
from halo_client.source import WebSource

_LOG = logging.getLogger("halo_client")
_SUBPROTOCOL = "halo.1.osc"
_RETRY_S = 0.5
"""Pause before the next attempt: a restarted service is found within a second."""
_OPEN_S = 5.0
_LARGEST = 65_507
"""Bytes of a message; the limit on every carrier."""


class WebSocketInput:
    """A connection that is opened again when it ends. `ClientError` without its library."""

    def __init__(self, source: WebSource) -> None:
        if importlib.util.find_spec("websockets") is None:
            raise ClientError(
                f"{source.url} needs the package websockets; "
                "`uv pip install './clients[web]'` installs it"
            )
        self.url = source.url
        self._ring = Ring()
        self._closed = threading.Event()
        self._connection: Any = None
        self._reason = ""
        self._thread = threading.Thread(target=self._run, name="websocket", daemon=True)
        self._thread.start()

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next bundle and its sender, or None after the timeout."""
        return self._ring.get(timeout_s)

    def close(self) -> None:
        """Disconnect. May be called twice."""
        self._closed.set()
        connection = self._connection
        if connection is not None:
            connection.close()
        self._thread.join(_OPEN_S)

    def _run(self) -> None:
        from websockets.exceptions import ConnectionClosed, InvalidHandshake

        while not self._closed.is_set():
            try:
                self._receive_all()
            except ConnectionClosed:
                self._reason = ""
            except (OSError, InvalidHandshake, EOFError) as error:
                self._warn(error)
            self._closed.wait(_RETRY_S)

    def _receive_all(self) -> None:
        from websockets.sync.client import connect
        from websockets.typing import Subprotocol

        # Without a proxy: a service on this machine or network is never behind one.
        with connect(
            self.url,
            subprotocols=[Subprotocol(_SUBPROTOCOL)],
            compression=None,
            proxy=None,
            open_timeout=_OPEN_S,
            close_timeout=1.0,
            max_size=_LARGEST,
        ) as connection:
            self._connection = connection
            if self._closed.is_set():
                return
            for message in connection:
                # Text is no bundle; as bytes it is counted and logged like any bad datagram.
                raw = message if isinstance(message, bytes) else message.encode()
                self._ring.put(raw, self.url)

    def _warn(self, error: Exception) -> None:
        reason = str(error)
        with contextlib.suppress(AttributeError):  # A refusal of the server states its remedy.
            reason = error.response.body.decode("utf-8", "replace").strip()[:200]  # type: ignore[attr-defined]
        if reason != self._reason:
            self._reason = reason
            _LOG.warning("cannot connect to %s (%s); trying again", self.url, reason)
