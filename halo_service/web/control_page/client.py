"""One open page: bounded queues, and the task that empties them."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import NamedTuple

from aiohttp import WSCloseCode, web

from halo_service.web.control_page.access import Role
from halo_service.web.subscriber import GONE, SEND_S

QUEUE = 90
"""Messages that wait for a slow page, about three seconds; then the oldest is dropped."""
PICTURES = frozenset({"depth", "infrared", "colour"})


class Message(NamedTuple):
    """What a page sent by its live connection."""

    client: PageClient
    value: dict[str, object]


class PageClient:
    """Belongs to the server's event loop."""

    def __init__(
        self, socket: web.WebSocketResponse, transport: asyncio.Transport | None, role: Role
    ) -> None:
        self._socket, self._transport = socket, transport
        self.role = role
        self.shows: frozenset[str] = frozenset()
        """Pictures that the page shows."""
        self._queue: deque[str] = deque(maxlen=QUEUE)
        self._pictures: dict[str, bytes] = {}
        self._filled = asyncio.Event()

    def put(self, text: str) -> None:
        """Queue a message; never waits."""
        self._queue.append(text)
        self._filled.set()

    def put_picture(self, kind: str, data: bytes) -> None:
        """Send a picture as soon as possible; a newer one replaces one that waits."""
        self._pictures[kind] = data
        self._filled.set()

    def wants(self, kind: str) -> bool:
        """Whether the page shows a kind of picture, and has got the last one."""
        return kind in self.shows and kind not in self._pictures

    async def run(self) -> None:
        """Send what is queued, until the page leaves or stops reading."""
        try:
            while not self._socket.closed:
                await self._filled.wait()
                self._filled.clear()
                while self._queue:
                    await asyncio.wait_for(self._socket.send_str(self._queue.popleft()), SEND_S)
                while self._pictures:
                    kind = next(iter(self._pictures))
                    data = self._pictures[kind]
                    await asyncio.wait_for(self._socket.send_bytes(data), SEND_S)
                    if self._pictures[kind] is data:
                        del self._pictures[kind]
        except GONE:
            if self._transport is not None:
                self._transport.abort()

    async def close(self) -> None:
        """Say goodbye to the page."""
        await self._socket.close(code=WSCloseCode.GOING_AWAY, message=b"the service ends")
