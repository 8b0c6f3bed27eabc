"""The server: one thread with an event loop, which frames are handed to."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable, Iterable

from aiohttp import WSMsgType, web

import halo_protocol as wire
from halo_protocol.handshake import HELLO
from halo_service.outputs.control import ControlMessage
from halo_service.outputs.outgoing import Outgoing
from halo_service.web.access import Access
from halo_service.web.http_log import http_log
from halo_service.web.listener import ConnectionLimit, bracketed, listening
from halo_service.web.oscquery import ATTRIBUTES, Node, find, host_info, stream_nodes, tree
from halo_service.web.requests import answer_hello, read_binary, read_text
from halo_service.web.settings import WebSettings
from halo_service.web.subscriber import JSON, OSC, Subscriber

log = logging.getLogger(__name__)

PATH = "/halo"
MAX_CLIENTS = 64
LARGEST = 4096
"""Bytes of a message from a client."""
HEARTBEAT_S = 10.0
"""How often an idle connection is checked."""
CLOSE_S = 5.0
IDLE_S = 10.0
"""A connection without a further request is closed after this time."""
LOCAL = {"0.0.0.0": "127.0.0.1", "::": "::1"}
"""Host that means all addresses -> the address of this machine."""
RETAINED = ("scene", "homography", "pose")
"""Sent at once to a client that joins."""


def _no_control(message: ControlMessage) -> None:
    """The default for `control`."""


class WebServer:
    """A carrier for browsers."""

    def __init__(
        self,
        settings: WebSettings,
        node: str = "",
        session: str = "",
        control: Callable[[ControlMessage], None] = _no_control,
        control_port: int = 0,
        control_host: str = "",
    ) -> None:
        """Listen. `control` gets what clients ask for, in the server's thread; `control_port` is
        the UDP port for the same messages, on `control_host` if that is not this server's.

        Raises `UserError` for a host that is not an address of this machine.
        """
        self._node, self._session = node, session
        self._control = control
        self._host_info = host_info(node, control_host, control_port)
        self.nodes: Callable[[], Iterable[Node]] = tuple
        """What clients can send, for OSCQuery; called in the server's thread."""
        self._access = Access(frozenset(settings.hosts), frozenset(settings.origins))
        self._listener = listening("web", settings.host, settings.port)
        here = LOCAL.get(settings.host, settings.host)
        self.url = f"ws://{bracketed(here)}:{self.port}{PATH}"
        """Where programs of this machine connect."""
        self._clients: set[Subscriber] = set()
        self._latest: dict[tuple[str, str], Outgoing] = {}
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="web", daemon=True)
        self._thread.start()
        self._runner = asyncio.run_coroutine_threadsafe(self._start(), self._loop).result()

    @property
    def port(self) -> int:
        """The TCP port that it uses."""
        return int(self._listener.getsockname()[1])

    @property
    def client_count(self) -> int:
        """Clients that receive the stream now; from any thread."""
        return len(self._clients)

    @property
    def clients(self) -> tuple[Subscriber, ...]:
        """Clients that receive the stream now; from any thread, to read what was sent to them."""
        return tuple(self._clients)

    def send(self, outgoing: Outgoing) -> None:
        """Hand a frame or report to the server's thread."""
        self._latest[outgoing.surface, outgoing.kind] = outgoing
        if self._clients:
            self._loop.call_soon_threadsafe(self._publish, outgoing)

    def close(self) -> None:
        """Disconnect all clients and end the thread."""
        stopped = asyncio.run_coroutine_threadsafe(self._stop(), self._loop)
        stopped.result(CLOSE_S * 2)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _stop(self) -> None:
        self._tcp.close()
        await self._runner.cleanup()

    async def _start(self) -> web.AppRunner:
        application = web.Application()
        application.router.add_get(PATH, self._subscribe)
        application.router.add_get("/{path:.*}", self._query)
        application.on_shutdown.append(self._disconnect)
        runner = web.AppRunner(
            application,
            access_log=None,
            logger=http_log(),
            shutdown_timeout=CLOSE_S,
            keepalive_timeout=IDLE_S,
            lingering_time=0.0,  # no request has a body that is worth waiting for
        )
        await runner.setup()
        server = runner.server
        assert server is not None
        self._tcp = await self._loop.create_server(
            lambda: ConnectionLimit(server), sock=self._listener
        )
        return runner

    def _publish(self, outgoing: Outgoing) -> None:
        for client in self._clients:
            client.put(outgoing)

    async def _subscribe(self, request: web.Request) -> web.StreamResponse:
        refusal = self._refusal(request)
        if refusal is not None:
            return refusal
        if len(self._clients) >= MAX_CLIENTS:
            return web.Response(status=503, text=f"at most {MAX_CLIENTS} clients can connect\n")
        if not _can_speak(request.headers.getall("Sec-WebSocket-Protocol", ())):
            return web.Response(status=400, text=f"choose the subprotocol {JSON} or {OSC}\n")
        answer = web.WebSocketResponse(
            protocols=(JSON, OSC), heartbeat=HEARTBEAT_S, max_msg_size=LARGEST, compress=False
        )
        try:
            is_websocket = bool(answer.can_prepare(request))
        except ValueError:  # its key is not ASCII
            is_websocket = False
        if not is_websocket:
            text = f"this is a WebSocket, protocol {wire.VERSION}; subprotocols {JSON}, {OSC}\n"
            return web.Response(status=426, text=text, headers={"Upgrade": "websocket"})
        await answer.prepare(request)
        await self._serve(answer, request.transport, request.remote or "")
        return answer

    async def _query(self, request: web.Request) -> web.Response:
        """Answer OSCQuery: a part of the namespace, one attribute of it, or the host's facts."""
        refusal = self._refusal(request)
        if refusal is not None:
            return refusal
        wanted = request.query_string
        if wanted == "HOST_INFO":
            return web.json_response(self._host_info)
        root = tree([*self.nodes(), *stream_nodes(list(self._latest.values()))])
        found = find(root, request.path)
        if found is None:
            return web.Response(status=404, text="there is no such address; / lists them all\n")
        if not wanted:
            return web.json_response(found)
        if wanted not in (*ATTRIBUTES, "TYPE", "FULL_PATH", "CONTENTS"):
            return web.Response(status=400, text="unknown attribute\n")
        if wanted not in found:
            return web.Response(status=204)
        return web.json_response({wanted: found[wanted]})

    def _refusal(self, request: web.Request) -> web.Response | None:
        why = self._access.refusal(request.headers.get("Host", ""), request.headers.get("Origin"))
        if why is None:
            return None
        log.debug("web: refused %s: %s", request.remote, why)
        return web.Response(status=403, text=why + "\n")

    async def _serve(
        self, answer: web.WebSocketResponse, transport: asyncio.Transport | None, host: str
    ) -> None:
        client = Subscriber(answer, transport)
        self._clients.add(client)
        sending = asyncio.create_task(client.run())
        for outgoing in list(self._latest.values()):
            if outgoing.kind in RETAINED:
                client.put(outgoing)
        try:
            async for message in answer:
                if message.type == WSMsgType.ERROR:
                    break
                if not await self._read(client, message.data, host):
                    break
        finally:
            self._clients.discard(client)
            sending.cancel()

    async def _read(self, client: Subscriber, data: bytes | str, host: str) -> bool:
        """Handle a client's message; false if its hello is refused, which ends its connection."""
        try:
            requests = [read_text(data)] if isinstance(data, str) else read_binary(data)
        except ValueError as error:
            log.debug("web: skipped a message of %s: %s", host, error)
            return True
        for address, arguments in requests:
            if address != HELLO:
                self._control(ControlMessage(address, arguments, (host, 0), LARGEST, client.answer))
                continue
            welcome, stream = answer_hello(
                arguments, self._node, self._session, binary=client.binary
            )
            if stream is None:
                await client.refuse(welcome)
                return False
            client.answer(welcome)
            client.choose(stream)
        return True

    async def _disconnect(self, _: web.Application) -> None:
        for client in list(self._clients):
            await client.close()


def _can_speak(offers: Iterable[str]) -> bool:
    """Whether a client offers one of our subprotocols, or none at all."""
    offered = {each.strip() for offer in offers for each in offer.split(",")}
    return not offered or not offered.isdisjoint((JSON, OSC))
