"""One WebSocket client: a bounded queue and the task that empties it."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress

from aiohttp import ClientError, WSCloseCode, web

from halo_service.outputs.destination import Stream
from halo_service.outputs.outgoing import Outgoing
from halo_service.outputs.stream_encoder import StreamEncoder
from halo_service.web.listener import bracketed
from halo_service.web.requests import write_text

OSC, JSON = "halo.1.osc", "halo.1.json"
"""Subprotocols: OSC bundles as binary messages, or JSON as text. Without one: JSON."""
QUEUE = 32
"""Frames and reports that wait for a slow client, one second; then the oldest is dropped."""
SEND_S = 10.0
"""A client that accepts nothing for so long is disconnected."""
GONE = (ConnectionError, ClientError, TimeoutError, RuntimeError)
"""What sending raises when the client has left or reads nothing."""


class Subscriber:
    """Belongs to the server's event loop."""

    def __init__(self, socket: web.WebSocketResponse, transport: asyncio.Transport | None) -> None:
        """`transport`: the connection below the socket."""
        self._socket = socket
        self._transport = transport
        self._loop = asyncio.get_running_loop()
        self.binary = socket.ws_protocol == OSC
        self._encoder = StreamEncoder(Stream())
        self._queue: deque[list[bytes | str]] = deque(maxlen=QUEUE)
        self._filled = asyncio.Event()
        self.dropped = 0
        """Frames and reports that this client was too slow for."""
        self.messages = self.bytes = 0
        """What was sent to it so far."""

    @property
    def address(self) -> str:
        """Host and port of the client."""
        peer = self._transport.get_extra_info("peername") if self._transport else None
        return f"{bracketed(peer[0])}:{peer[1]}" if peer else "unknown"

    def choose(self, stream: Stream) -> None:
        """Send another stream from now on."""
        self._encoder = StreamEncoder(stream)

    def put(self, outgoing: Outgoing) -> None:
        """Queue a frame or report; never waits."""
        if self.binary:
            self._append([*self._encoder.datagrams(outgoing)])
        elif (chosen := self._encoder.chosen(outgoing)) is not None:
            self._append([chosen.text])

    def answer(self, datagram: bytes) -> None:
        """Queue the answer to a control message; from any thread."""
        self._loop.call_soon_threadsafe(self._append, [self._written(datagram)])

    async def refuse(self, datagram: bytes) -> None:
        """Send the last answer before the connection ends."""
        with suppress(*GONE):
            await asyncio.wait_for(self._send([self._written(datagram)]), SEND_S)

    def _written(self, datagram: bytes) -> bytes | str:
        return datagram if self.binary else write_text(datagram)

    def _append(self, messages: list[bytes | str]) -> None:
        if messages:
            self.dropped += len(self._queue) == QUEUE
            self._queue.append(messages)
            self._filled.set()

    async def run(self) -> None:
        """Send what is queued, until the client leaves or stops reading."""
        try:
            while not self._socket.closed:
                await self._filled.wait()
                self._filled.clear()
                while self._queue and not self._socket.closed:
                    await asyncio.wait_for(self._send(self._queue.popleft()), SEND_S)
        except GONE:
            # It has left, or reads nothing: its connection ends, the others go on.
            self._abort()

    async def _send(self, messages: list[bytes | str]) -> None:
        for message in messages:
            self.messages += 1
            self.bytes += len(message)
            if isinstance(message, str):
                await self._socket.send_str(message)
            else:
                await self._socket.send_bytes(message)

    async def close(self) -> None:
        """Say goodbye to the client."""
        await self._socket.close(code=WSCloseCode.GOING_AWAY, message=b"the service ends")

    def _abort(self) -> None:
        if self._transport is not None:
            self._transport.abort()
