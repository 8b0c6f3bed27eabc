"""Sends inputs to a running service, by UDP, HTTP and WebSocket; each in a process of its own."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import struct
from collections.abc import Awaitable, Callable

import aiohttp

from fuzzing.inputs import Inputs, osc
from halo_protocol.handshake import CONTROL

BURST = 60
"""Datagrams between two questions for the status: what a receive buffer of the system holds."""
ANSWER_S = 2.0
TRIES = 3
"""A question can be lost, as every datagram."""
PATIENCE_S = 0.02
PARALLEL = 8
"""HTTP and WebSocket connections at a time."""
PER_CONNECTION = 100
CLOSE = aiohttp.ClientWSTimeout(ws_close=1.0)
QUESTION = osc(f"{CONTROL}status", "." * 256)
NO_WAIT = struct.pack("ii", 1, 0)
"""SO_LINGER: a closed connection leaves no port that waits for a minute."""


def send_datagrams(port: int, seed: int, count: int) -> int:
    """Send to the control port; return how many bursts were followed by no answer."""
    inputs, unanswered = Inputs(seed), 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as attacker:
        attacker.connect(("127.0.0.1", port))
        attacker.settimeout(ANSWER_S)
        for first in range(0, count, BURST):
            for _ in range(min(BURST, count - first)):
                attacker.send(inputs.datagram()[:60_000])
            unanswered += not _answered(attacker)
    return unanswered


def _answered(attacker: socket.socket) -> bool:
    """Whether the service says its status; welcomes of mutated hellos come before it."""
    for _ in range(TRIES):
        attacker.send(QUESTION)
        with contextlib.suppress(TimeoutError):
            while not attacker.recv(65_536).startswith(f"{CONTROL}status".encode()):
                pass
            return True
    return False


def send_requests(port: int, seed: int, count: int) -> int:
    """Send HTTP requests, one a connection; return how many were not answered or closed."""
    return asyncio.run(_in_parallel(lambda n: _requests(port, seed + n, count // PARALLEL)))


def send_messages(port: int, seed: int, count: int) -> int:
    """Send WebSocket messages; return how many connections could not be opened."""
    return asyncio.run(_in_parallel(lambda n: _messages(port, seed + n, count // PARALLEL)))


async def _in_parallel(one: Callable[[int], Awaitable[int]]) -> int:
    return sum(await asyncio.gather(*map(one, range(PARALLEL))))


async def _requests(port: int, seed: int, count: int) -> int:
    inputs, silent = Inputs(seed), 0
    for _ in range(count):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        raw: socket.socket = writer.get_extra_info("socket")
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, NO_WAIT)
        writer.write(inputs.request())
        try:
            with contextlib.suppress(OSError):
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(reader.read(), PATIENCE_S)
                writer.write_eof()  # if the request looks unfinished
                await asyncio.wait_for(reader.read(), ANSWER_S)
        except TimeoutError:
            silent += 1
        writer.close()
    return silent


async def _messages(port: int, seed: int, count: int) -> int:
    inputs, failed, sent, number = Inputs(seed), 0, 0, seed
    async with aiohttp.ClientSession() as session:
        while sent < count:
            number += 1
            try:
                left = min(PER_CONNECTION, count - sent)
                sent += await _connection(session, port, inputs, left, number)
            except (aiohttp.ClientError, OSError):
                failed += 1
                sent += PER_CONNECTION
    return failed


async def _connection(
    session: aiohttp.ClientSession, port: int, inputs: Inputs, count: int, number: int
) -> int:
    """Send up to `count` messages, until the service closes; every third client reads nothing."""
    protocol = ("halo.1.osc", "halo.1.json")[number % 2]
    address = f"http://127.0.0.1:{port}/halo"
    async with session.ws_connect(address, protocols=(protocol,), timeout=CLOSE) as web:
        reading = asyncio.create_task(_read_all(web)) if number % 3 else None
        for n in range(count):
            message = inputs.message()
            with contextlib.suppress(ConnectionError):
                if isinstance(message, str):
                    await web.send_str(message)
                else:
                    await web.send_bytes(message)
            if web.closed:
                count = n + 1
                break
        if reading is not None:
            reading.cancel()
    return count


async def _read_all(web: aiohttp.ClientWebSocketResponse) -> None:
    async for _ in web:
        pass
