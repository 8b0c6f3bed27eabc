"""The server: one thread with an event loop, and a few for calls that take longer."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import secrets
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from aiohttp import WSMsgType, web

from halo_service.errors import UserError
from halo_service.web.control_page.access import HEADER, PageAccess, Refused, Role
from halo_service.web.control_page.calls import LARGEST_FILE, Call
from halo_service.web.control_page.client import PICTURES, Message, PageClient
from halo_service.web.control_page.files import StaticFile, static_files
from halo_service.web.http_log import http_log
from halo_service.web.listener import ConnectionLimit, bracketed, listening
from halo_service.web.server import CLOSE_S, HEARTBEAT_S, IDLE_S, LARGEST, LOCAL
from halo_service.web.settings import PageSettings

log = logging.getLogger(__name__)

MAX_PAGES = 16
CALL_THREADS, MAX_CALLS = 2, 8
"""Calls that run at once, and those that wait with them."""
COOKIE = "halo_page"
HOST = re.compile(r"[\w.:\[\]-]{1,255}", re.ASCII)
SECURITY = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class PageServer:
    """Serves the page until it is closed."""

    def __init__(
        self,
        settings: PageSettings,
        addresses: frozenset[str] = frozenset(),
    ) -> None:
        """Listen. `addresses`: of this machine, under which a network opens the page.

        Raises `UserError` for a host that is not an address of this machine.
        """
        self.calls: Mapping[str, Call] = {}
        """What the page can ask for, by name; set it before a page is opened."""
        self.on_message: Callable[[Message], None] = lambda message: None
        self.on_join: Callable[[PageClient], None] = lambda client: None
        """Both are called in the server's thread."""
        self._files = static_files()
        self.clients: set[PageClient] = set()
        self._busy = 0
        self._listener = listening("page", settings.host, settings.port)
        self.port = int(self._listener.getsockname()[1])
        """The TCP port that it uses."""
        local = settings.host in ("127.0.0.1", "::1", "localhost")
        token = settings.token or secrets.token_urlsafe(18)
        self.tokens: dict[str, Role] = (
            {} if local else {token: "operator", secrets.token_urlsafe(18): "viewer"}
        )
        """Empty on the loopback."""
        hosts = addresses | set(settings.hosts) if not local else frozenset()
        self._access = PageAccess(frozenset(hosts), self.tokens)
        self.url = f"http://{bracketed(LOCAL.get(settings.host, settings.host))}:{self.port}/"
        """Where this machine opens it, without a token."""
        self._pool = ThreadPoolExecutor(CALL_THREADS, "page call")
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="page", daemon=True)
        self._thread.start()
        self._runner = asyncio.run_coroutine_threadsafe(self._start(), self._loop).result()

    def post(self, task: Callable[[], None]) -> None:
        """Run a function in the server's thread soon; from any thread."""
        self._loop.call_soon_threadsafe(task)

    def broadcast(self, value: Mapping[str, Any]) -> None:
        """Send a JSON value to all pages; from the server's thread."""
        if not self.clients:
            return
        text = json.dumps(value, separators=(",", ":"), allow_nan=False)
        for client in self.clients:
            client.put(text)

    def wanted(self) -> set[str]:
        """Return the pictures that a page waits for; from any thread."""
        clients = tuple(self.clients)
        return {kind for kind in PICTURES if any(client.wants(kind) for client in clients)}

    def shows(self, kind: str) -> bool:
        """Whether a page shows a kind of picture; from any thread."""
        return any(kind in client.shows for client in tuple(self.clients))

    def send_picture(self, kind: str, data: bytes) -> None:
        """Send a picture to the pages that show it; from the server's thread."""
        for client in self.clients:
            if client.wants(kind):
                client.put_picture(kind, data)

    def close(self) -> None:
        """Disconnect all pages and end the threads."""
        asyncio.run_coroutine_threadsafe(self._stop(), self._loop).result(CLOSE_S * 2)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        self._pool.shutdown(wait=False, cancel_futures=True)

    async def _stop(self) -> None:
        self._tcp.close()
        await self._runner.cleanup()

    async def _start(self) -> web.AppRunner:
        application = web.Application(client_max_size=LARGEST_FILE)
        application.router.add_get("/live", self._guarded(self._live))
        application.router.add_post("/call/{name}", self._guarded(self._call))
        application.router.add_get("/{path:.*}", self._guarded(self._file))
        application.on_shutdown.append(self._disconnect)
        runner = web.AppRunner(
            application,
            access_log=None,
            logger=http_log(),
            shutdown_timeout=CLOSE_S,
            keepalive_timeout=IDLE_S,
            lingering_time=0.0,
        )
        await runner.setup()
        server = runner.server
        assert server is not None
        self._tcp = await self._loop.create_server(
            lambda: ConnectionLimit(server), sock=self._listener
        )
        return runner

    def _guarded(self, handler: Callable[[web.Request, Role], Any]) -> Callable[[web.Request], Any]:
        """Check who asks before a handler runs, and answer what it refuses."""

        async def guarded(request: web.Request) -> web.StreamResponse:
            try:
                token = request.query.get("token") or request.cookies.get(self._cookie)
                role = self._access.role(request.headers.get("Host", ""), token)
                answer: web.StreamResponse = await handler(request, role)
            except Refused as refused:
                log.debug("page: refused %s: %s", request.remote, refused)
                return web.json_response(
                    {"error": str(refused)}, status=refused.status, headers=SECURITY
                )
            return answer

        return guarded

    @property
    def _cookie(self) -> str:
        """The cookie's name: cookies of one host are shared by its ports."""
        return f"{COOKIE}_{self.port}"

    async def _file(self, request: web.Request, role: Role) -> web.Response:
        del role
        file = self._files.get(request.path)
        if file is None:
            raise Refused(404, "there is no such page")
        headers = {
            **SECURITY,
            "Content-Security-Policy": _policy(request.headers.get("Host", "")),
            "ETag": file.etag,
            "Vary": "Accept-Encoding",
        }
        if request.headers.get("If-None-Match") == file.etag:
            return web.Response(status=304, headers=headers)
        answer = _whole(request, file, headers)
        token = request.query.get("token")
        if token is not None and self.tokens:
            answer.set_cookie(
                self._cookie, token, max_age=30 * 86_400, httponly=True, samesite="Strict"
            )
        return answer

    async def _call(self, request: web.Request, role: Role) -> web.Response:
        """Run a call and answer with its value, or with the sentence of its refusal."""
        self._access.check_origin(request.headers.get("Host", ""), request.headers.get("Origin"))
        if request.headers.get(HEADER) != "1":
            raise Refused(403, "only the control page itself may send this")
        call = self.calls.get(request.match_info["name"])
        if call is None:
            raise Refused(404, "there is no such call")
        if role == "viewer" and not call.reads:
            raise Refused(403, "this address may only look; use the operator's address")
        if (request.content_length or 0) > call.largest:
            raise Refused(413, f"too large: at most {call.largest >> 10} kB")
        if self._busy >= MAX_CALLS:
            raise Refused(503, "the service is busy; try again")
        self._busy += 1
        try:
            return await self._answer(call, await _body(request, call.largest))
        finally:
            self._busy -= 1

    async def _answer(self, call: Call, body: bytes) -> web.Response:
        try:
            value = call.value(body)
        except ValueError as error:
            raise Refused(400, "send a JSON object") from error
        try:
            result = await self._loop.run_in_executor(self._pool, call.run, value)
        except UserError as error:
            raise Refused(422, str(error)) from error
        except (KeyError, TypeError, ValueError) as error:
            # A request that our own page does not send; the text could quote the request.
            log.debug("page: a call failed: %r", error)
            raise Refused(400, "this request misses a value, or has one of another type") from error
        if isinstance(result, bytes):
            return web.Response(
                body=result, content_type="application/octet-stream", headers=SECURITY
            )
        return web.json_response(result, headers=SECURITY)

    async def _live(self, request: web.Request, role: Role) -> web.StreamResponse:
        self._access.check_origin(request.headers.get("Host", ""), request.headers.get("Origin"))
        if len(self.clients) >= MAX_PAGES:
            raise Refused(503, f"at most {MAX_PAGES} pages can be open")
        answer = web.WebSocketResponse(heartbeat=HEARTBEAT_S, max_msg_size=LARGEST, compress=False)
        try:
            if not answer.can_prepare(request):
                raise Refused(426, "this is a WebSocket")
        except ValueError as error:  # its key is not ASCII
            raise Refused(400, "this is a WebSocket") from error
        await answer.prepare(request)
        client = PageClient(answer, request.transport, role)
        self.clients.add(client)
        sending = asyncio.create_task(client.run())
        try:
            self.on_join(client)
            async for message in answer:
                if message.type is not WSMsgType.TEXT:
                    break
                self._read(client, message.data)
        finally:
            self.clients.discard(client)
            sending.cancel()
        return answer

    def _read(self, client: PageClient, text: str) -> None:
        """Note what a page shows; pass on what an operator's page reports."""
        try:
            value = json.loads(text)
        except (ValueError, RecursionError):
            return
        if not isinstance(value, dict):
            return
        shows = value.get("show")
        if isinstance(shows, list):
            client.shows = PICTURES.intersection(each for each in shows if isinstance(each, str))
        elif client.role == "operator":
            self.on_message(Message(client, value))

    async def _disconnect(self, _: web.Application) -> None:
        for client in list(self.clients):
            await client.close()


async def _body(request: web.Request, largest: int) -> bytes:
    """Read a request's body; its stated length may be wrong or missing."""
    chunks, size = [], 0
    async for chunk in request.content.iter_chunked(64 << 10):
        size += len(chunk)
        if size > largest:
            raise Refused(413, f"too large: at most {largest >> 10} kB")
        chunks.append(chunk)
    return b"".join(chunks)


def _whole(request: web.Request, file: StaticFile, headers: dict[str, str]) -> web.Response:
    zipped = "gzip" in request.headers.get("Accept-Encoding", "")
    return web.Response(
        body=file.zipped if zipped else file.content,
        headers={
            **headers,
            "Content-Type": file.type,
            **({"Content-Encoding": "gzip"} if zipped else {}),
        },
    )


def _policy(host: str) -> str:
    """Return the Content-Security-Policy: nothing from outside, no inline scripts."""
    # Older Safari does not count a WebSocket of the same host as 'self'.
    here = f" ws://{host}" if HOST.fullmatch(host) else ""
    return (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        f"connect-src 'self'{here}; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )
