"""One WebSocket client: a bounded queue and the task that empties it."""

from __future__ import annotations

import asyncio
from collections import deque

from aiohttp import ClientError, WSCloseCode, web

from halo_service.outputs.outgoing import Outgoing
from halo_service.web.views import json_text

OSC, JSON = "halo.1.osc", "halo.1.json"
"""Subprotocols: OSC bundles as binary messages, or JSON as text. Without one: JSON."""
QUEUE = 32
"""Frames and reports that wait for a slow client, one second; then the oldest is dropped."""
SEND_S = 10.0
"""A client that accepts nothing for so long is disconnected."""


class Subscriber:
    """Belongs to the server's event loop."""

    def __init__(self, socket: web.WebSocketResponse, transport: asyncio.Transport | None) -> None:
        """`transport`: the connection below the socket."""
        self._socket = socket
        self._transport = transport
        self._binary = socket.ws_protocol == OSC
        self._queue: deque[Outgoing] = deque(maxlen=QUEUE)
        self._filled = asyncio.Event()
        self.dropped = 0
        """Frames and reports that this client was too slow for."""

    def put(self, outgoing: Outgoing) -> None:
        """Queue a frame or report; never waits."""
        self.dropped += len(self._queue) == QUEUE
        self._queue.append(outgoing)
        self._filled.set()

    async def run(self) -> None:
        """Send what is queued, until the client leaves or stops reading."""
        try:
            while not self._socket.closed:
                await self._filled.wait()
                self._filled.clear()
                while self._queue and not self._socket.closed:
                    await asyncio.wait_for(self._send(self._queue.popleft()), SEND_S)
        except (ConnectionError, ClientError, TimeoutError, RuntimeError):
            # It has left, or reads nothing: its connection ends, the others go on.
            self._abort()

    async def _send(self, outgoing: Outgoing) -> None:
        if not self._binary:
            await self._socket.send_str(json_text(outgoing))
            return
        for datagram in outgoing.datagrams:
            await self._socket.send_bytes(datagram)

    async def close(self) -> None:
        """Say goodbye to the client."""
        await self._socket.close(code=WSCloseCode.GOING_AWAY, message=b"the service ends")

    def _abort(self) -> None:
        if self._transport is not None:
            self._transport.abort()
