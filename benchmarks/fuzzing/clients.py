"""Sends inputs to our client libraries, with the frames of a good service between them."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from threading import Semaphore, Thread

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve
from websockets.typing import Subprotocol

import halo_client
from fuzzing.inputs import Inputs
from fuzzing.service import memory_mb
from halo_protocol import Frame, TouchFrame, encode_frame

EACH = 10
"""A good frame comes after so many inputs."""
PER_CONNECTION = 2_000
"""Inputs until the hostile server sends bytes that are no WebSocket, which ends the connection."""
SHOWN_S = 1.0
"""Longest wait for a good frame; without it the client has lost one, which is a failure."""
DECODER = Path(__file__).with_name("decoder.mjs")


@dataclass
class Result:
    """What a client did."""

    sent: int
    good: int
    """Frames of the good service that were sent ..."""
    shown: int
    """... and that were shown."""
    memory_mb: tuple[float, float]
    """After a fifth of the inputs, and at the end."""


def good_frame(number: int) -> bytes:
    """Return a frame of the good service."""
    header = Frame("good", "s1", number, 1_700_000_000 + number, 0, 0, number)
    return encode_frame("table", header, [])[0]


def python_by_udp(count: int, seed: int) -> Result:
    """Send to the port of the Python client."""
    inputs, good, shown, early_mb = Inputs(seed), 0, 0, 0.0
    with (
        halo_client.connect("osc://127.0.0.1:0?node=good") as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        port = int(receiver.url.rpartition(":")[2])
        sender.connect(("127.0.0.1", port))
        for n in range(count):
            if n == count // 5:
                early_mb = memory_mb()
            sender.send(inputs.datagram())
            receiver.poll(1.0)
            if n % EACH == 0:
                good += 1
                sender.send(good_frame(good))
                shown += sum(isinstance(event, TouchFrame) for event in receiver.poll(1.0))
    return Result(count, good, shown, (early_mb, memory_mb()))


def python_by_websocket(count: int, seed: int) -> Result:
    """Let the Python client connect to a server that sends inputs."""
    inputs, sent, good, arrived = Inputs(seed), 0, 0, Semaphore(0)

    def attack(connection: ServerConnection) -> None:
        nonlocal sent, good
        try:
            for n in range(min(PER_CONNECTION, count - sent)):
                connection.send(inputs.message())
                sent += 1
                if n % EACH == 0:
                    good += 1
                    connection.send(good_frame(good))
                    arrived.acquire(timeout=SHOWN_S)  # the client's queue of 256 has an end
            connection.socket.sendall(inputs.request())
        except (ConnectionClosed, OSError):
            return

    shown, early_mb, done_s = 0, 0.0, None
    server = serve(attack, "127.0.0.1", 0, subprotocols=[Subprotocol("halo.1.osc")])
    port = server.socket.getsockname()[1]
    Thread(target=server.serve_forever, daemon=True).start()
    with halo_client.connect(f"ws://127.0.0.1:{port}/halo?node=good") as receiver:
        while done_s is None or time.monotonic() < done_s + 1.0:
            frames = sum(isinstance(event, TouchFrame) for event in receiver.poll(0.1))
            shown += frames
            if frames:
                arrived.release(frames)
            early_mb = early_mb or (memory_mb() if sent > count // 5 else 0.0)
            if done_s is None and sent >= count:
                done_s = time.monotonic()
    server.shutdown()
    return Result(sent, good, shown, (early_mb, memory_mb()))


def javascript(count: int, seed: int) -> Result | None:
    """Let halo.js read inputs in node; None where node is not installed."""
    if shutil.which("node") is None:
        return None
    command = ["node", "--expose-gc", str(DECODER), str(count)]
    inputs, good = Inputs(seed), 0
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as node:
        assert node.stdin is not None and node.stdout is not None
        for n in range(count):
            node.stdin.write(inputs.datagram().hex() + "\n")
            if n % EACH == 0:
                good += 1
                node.stdin.write(good_frame(good).hex() + "\n")
        node.stdin.close()
        said = node.stdout.read()
    if node.returncode:
        raise SystemExit("halo.js: node ended with an error")
    found = json.loads(said)
    return Result(count, good, found["shown"], (found["early_mb"], found["late_mb"]))
