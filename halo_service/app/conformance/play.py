"""Sends the scripted stream, by UDP or over a WebSocket."""

from __future__ import annotations

import asyncio
import socket
import time
from collections.abc import Callable

from aiohttp import web

from halo_service.app.conformance.script import steps
from halo_service.errors import UserError

PATH = "/halo"
SUBPROTOCOL = "halo.1.osc"


def play_udp(host: str, port: int) -> None:
    """Send everything to a client that listens. Raises `UserError` if its host is unknown."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except OSError as error:
        raise UserError(f"conformance: no address of '{host}' is found; check --osc") from error
    started_s = time.monotonic()
    with socket.socket(family, socket.SOCK_DGRAM) as sender:
        for step in steps():
            time.sleep(max(0.0, started_s + step.at_s - time.monotonic()))
            if step.datagram is not None:
                sender.sendto(step.datagram, address)


def play_websocket(port: int, ready: Callable[[str], object] = lambda url: None) -> None:
    """Wait for a client of this machine and send everything to the first one.

    `ready` is called with the URL. Raises `UserError` if the port is in use.
    """
    asyncio.run(_serve(port, ready))


async def _serve(port: int, ready: Callable[[str], object]) -> None:
    played = asyncio.Event()
    begun = False

    async def play(request: web.Request) -> web.StreamResponse:
        nonlocal begun
        if begun:
            return web.Response(status=503, text="one client is served, once\n")
        answer = web.WebSocketResponse(protocols=(SUBPROTOCOL,), compress=False)
        if not answer.can_prepare(request):
            return web.Response(status=426, text="this is a WebSocket\n")
        begun = True
        try:
            await answer.prepare(request)
            await _send_all(answer)
        finally:
            played.set()
        return answer

    application = web.Application()
    application.router.add_get(PATH, play)
    runner = web.AppRunner(application, access_log=None, shutdown_timeout=1.0)
    await runner.setup()
    try:
        site = web.TCPSite(runner, "127.0.0.1", port)
        try:
            await site.start()
        except OSError as error:
            raise UserError(
                f"conformance: port {port} is in use; choose another one with --web PORT"
            ) from error
        ready(f"ws://127.0.0.1:{port}{PATH}")
        await played.wait()
    finally:
        await runner.cleanup()


async def _send_all(answer: web.WebSocketResponse) -> None:
    started_s = time.monotonic()
    for step in steps():
        await asyncio.sleep(max(0.0, started_s + step.at_s - time.monotonic()))
        if answer.closed:
            raise UserError("conformance: the client has left before the end; start again")
        if step.datagram is not None:
            await answer.send_bytes(step.datagram)
    await answer.close()
