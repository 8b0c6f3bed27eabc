"""Clients for `outputs.py`, many in one process: `python receivers.py KIND COUNT ENDPOINT`.

`udp` prints its ports; all print `ready`, and, when their input is closed, how many frames each
client got and how late they were.
"""

from __future__ import annotations

import asyncio
import json
import select
import socket
import struct
import sys
import threading
import time
from statistics import median

import aiohttp
import zenoh

from halo_protocol.osc import IMMEDIATELY, bundle, padded

BEFORE = bundle(IMMEDIATELY, padded("/halo/1/table/frame") + padded(",ssiiiii") + padded("desk"))
TIME_AT = len(BEFORE + padded("s1")) + 4
"""Where a frame's header has its time, in a bundle of this node and session."""


class Counter:
    """What all clients of this process got."""

    def __init__(self, count: int) -> None:
        self.frames = [0] * count
        self.late_ms: list[float] = []

    def receive(self, client: int, data: bytes | str) -> None:
        """Count a part of a frame; its time is the moment of publishing, on a monotonic clock."""
        if isinstance(data, str):
            seconds, rest_us = divmod(int(data.partition('"time_us":')[2].partition(",")[0]), 10**6)
        else:
            seconds, rest_us = struct.unpack_from(">ii", data, TIME_AT)
        self.late_ms.append((time.monotonic() - seconds) * 1e3 - rest_us / 1e3)
        self.frames[client] += 1

    def text(self) -> str:
        """Return everything in one line."""
        ordered = sorted(self.late_ms) or [0.0]
        p99_ms = ordered[int(0.99 * (len(ordered) - 1))]
        return json.dumps({"frames": self.frames, "ms": median(ordered), "p99_ms": p99_ms})


def main() -> None:
    """Receive until standard input is closed."""
    kind, count, endpoint = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    ended = threading.Event()
    threading.Thread(target=wait_for_end, args=(ended,), daemon=True).start()
    counter = Counter(count)
    receive = {"udp": by_udp, "websocket": by_websocket, "json": by_json, "zenoh": by_zenoh}[kind]
    receive(counter, endpoint, ended)
    print(counter.text())


def wait_for_end(ended: threading.Event) -> None:
    """Set when standard input is closed."""
    sys.stdin.read()
    ended.set()


def by_udp(counter: Counter, endpoint: str, ended: threading.Event) -> None:
    """Listen on ports of its own."""
    del endpoint
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in counter.frames]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    numbers = {each.fileno(): n for n, each in enumerate(sockets)}
    print(json.dumps([each.getsockname()[1] for each in sockets]))
    print("ready", flush=True)
    poll = select.epoll()
    for number in numbers:
        poll.register(number, select.EPOLLIN)
    while not ended.is_set():
        for number, _ in poll.poll(0.1):
            counter.receive(numbers[number], sockets[numbers[number]].recv(65_536))


def by_websocket(counter: Counter, url: str, ended: threading.Event) -> None:
    """Connect to a WebSocket."""
    asyncio.run(_websockets(counter, url, ended, "halo.1.osc"))


def by_json(counter: Counter, url: str, ended: threading.Event) -> None:
    """Connect to a WebSocket and receive text."""
    asyncio.run(_websockets(counter, url, ended, "halo.1.json"))


async def _websockets(counter: Counter, url: str, ended: threading.Event, protocol: str) -> None:
    async with aiohttp.ClientSession() as session:
        sockets = [await session.ws_connect(url, protocols=(protocol,)) for _ in counter.frames]
        print("ready", flush=True)
        reading = [asyncio.create_task(_read(counter, n, each)) for n, each in enumerate(sockets)]
        while not ended.is_set():
            await asyncio.sleep(0.1)
        for task in reading:
            task.cancel()


async def _read(counter: Counter, client: int, web: aiohttp.ClientWebSocketResponse) -> None:
    async for message in web:
        counter.receive(client, message.data)


def by_zenoh(counter: Counter, endpoint: str, ended: threading.Event) -> None:
    """Open sessions that subscribe."""
    sessions = [_session(endpoint) for _ in counter.frames]
    subscribers = [
        session.declare_subscriber(
            "halo/1/*/*/frame",
            lambda sample, n=n: counter.receive(n, sample.payload.to_bytes()),  # type: ignore[misc]
        )
        for n, session in enumerate(sessions)
    ]
    time.sleep(1.0)
    print("ready", flush=True)
    ended.wait()
    for subscriber in subscribers:
        subscriber.undeclare()
    for session in sessions:
        session.close()


def _session(endpoint: str) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


if __name__ == "__main__":
    main()
