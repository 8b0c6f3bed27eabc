"""The processes of the benchmark: router, nodes without cameras, subscriber.

Each role runs in a process of its own and answers through a pipe. Nodes send by the real encoder
and the real Zenoh output.
"""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import zenoh
from fuzzing.service import free_port

import halo_protocol as wire
from halo_client import ZenohSource
from halo_client.zenoh_input import zenoh_config
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
from scaling.model import FRAME_HZ

SIZE_MM = (300.0, 200.0)
SCENE = wire.Scene(
    "n000", "s1", wire.VERSION, *SIZE_MM, 2, 1, 0, FRAME_HZ, service_version="0.1.0",
    zenoh_version="1.10.2",
)  # fmt: skip
HEALTH = wire.Health("n000", "s1", FRAME_HZ, 3.5, 0, 0, 3, 1)
OPENERS = 8
"""Sessions that are opened at the same time."""
START_S = 120.0
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Usage:
    """What a process has used so far."""

    cpu_s: float
    memory_mb: float

    @classmethod
    def of(cls, pid: int) -> Usage:
        """Read it from the system. Linux alone."""
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
        megabytes = pages * os.sysconf("SC_PAGE_SIZE") / 1e6
        return cls((int(fields[11]) + int(fields[12])) / TICKS, megabytes)


class Role:
    """A process that does what it is asked for through a pipe."""

    def __init__(self, target: Callable[..., None], *arguments: object) -> None:
        """`target`: gets the pipe's other end first."""
        context = get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=target, args=(other, *arguments), daemon=True)
        self._process.start()
        other.close()
        self.wait()

    @property
    def usage(self) -> Usage:
        """What the process has used so far."""
        assert self._process.pid is not None
        return Usage.of(self._process.pid)

    def ask(self, request: object) -> Any:
        """Send a request and return its answer."""
        self._pipe.send(request)
        return self.wait()

    def wait(self) -> Any:
        """Return the next answer."""
        if not self._pipe.poll(START_S):
            raise SystemExit("a process of the benchmark does not answer")
        return self._pipe.recv()

    def start(self) -> None:
        """Let the nodes send."""
        self._pipe.send("start")

    def close(self) -> None:
        """End the process."""
        self._pipe.send(None)
        self._process.join(30.0)
        self._process.kill()


class Router:
    """`halo router` in its own process."""

    def __init__(self, connect: Sequence[str] = ()) -> None:
        self.port = free_port(socket.SOCK_STREAM)
        self.endpoint = f"tcp/127.0.0.1:{self.port}"
        halo = Path(sys.executable).with_name("halo")
        options = [word for each in connect for word in ("--connect", each)]
        self._process = subprocess.Popen(
            [halo, "router", "--listen", self.endpoint, *options], stderr=subprocess.DEVNULL
        )
        until_s = time.monotonic() + START_S
        while socket.socket().connect_ex(("127.0.0.1", self.port)):
            if time.monotonic() > until_s:
                raise SystemExit("the router did not start")
            time.sleep(0.1)

    @property
    def usage(self) -> Usage:
        """What the process has used so far."""
        return Usage.of(self._process.pid)

    @property
    def bytes(self) -> np.ndarray:
        """Bytes and segments of TCP so far: received, sent, data segments in, segments out."""
        command = ["ss", "-tinH", "state", "established", f"( sport = :{self.port} )"]
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        names = ("bytes_received", "bytes_sent", "data_segs_in", "data_segs_out")
        return np.array([sum(map(int, re.findall(rf"\b{name}:(\d+)", text))) for name in names])

    def close(self) -> None:
        """End the process."""
        self._process.send_signal(signal.SIGTERM)
        self._process.wait(30.0)


def nodes(pipe: Connection, endpoint: str, names: Sequence[str], pointers: int) -> None:
    """Send frames, scenes and healths of nodes until a request comes; answer with the counts."""
    settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,))
    with ThreadPoolExecutor(OPENERS) as pool:
        outputs = list(pool.map(lambda name: ZenohOutput(settings, name, "table"), names))
    pipe.send("open")
    pipe.recv()
    sent = np.zeros(4, np.int64)
    number = 0
    next_s = time.monotonic()
    while True:
        number += 1
        for position, output in enumerate(outputs):
            due_s = next_s + position / len(outputs) / FRAME_HZ
            time.sleep(max(0.0, due_s - time.monotonic()))
            send(output, names[position], number, position, pointers, sent)
        next_s += 1.0 / FRAME_HZ
        if pipe.poll():
            if pipe.recv() is None:
                break
            pipe.send(sent.copy())
    for output in outputs:
        output.close()


def send(
    output: ZenohOutput, name: str, number: int, position: int, pointers: int, sent: np.ndarray
) -> None:
    """Send what is due; add to `sent`: messages and bytes of frames, then of reports."""
    if (number + position) % 15 == 0:
        for report in (SCENE, HEALTH) if (number + position) % 30 == 0 else (SCENE,):
            outgoing = OutgoingReport("table", replace(report, node=name))
            output.send(outgoing)
            sent[2:] += 1, len(outgoing.datagrams[0])
    time_s, time_frac_us = divmod(time.monotonic_ns() // 1000, 1_000_000)
    header = wire.Frame(name, "s1", number, time_s, time_frac_us, pointers)
    frame = OutgoingFrame("table", SIZE_MM, header, POINTERS[:pointers], (), ())
    output.send(frame)
    sent[:2] += len(frame.datagrams), sum(map(len, frame.datagrams))


POINTERS = tuple(
    wire.Pointer(i, i, 2, 1, 1, 0.5, 0.25, 150.0, 50.0, 0.0, 0.5, 1.0, 2.0, 0.9, 3, -1.0)
    for i in range(10)
)


def subscriber(pipe: Connection, endpoint: str, keys: Sequence[str]) -> None:
    """Receive; `begin` forgets what came so far, `end` is answered with what came since."""
    arrived: list[tuple[bytes, int]] = []

    def store(sample: zenoh.Sample) -> None:
        arrived.append((sample.payload.to_bytes(), time.monotonic_ns()))

    with zenoh.open(zenoh_config(ZenohSource((endpoint,), mode="client"))) as session:
        subscribers = [session.declare_subscriber(key, store) for key in keys]
        pipe.send("open")
        while (request := pipe.recv()) is not None:
            received = list(arrived)
            arrived.clear()
            pipe.send(summary(received) if request == "end" else None)
        for each in subscribers:
            each.undeclare()


def summary(received: Sequence[tuple[bytes, int]]) -> dict[str, Any]:
    """Return the number of messages, their bytes, ms of each frame's way, and lost frames."""
    late_ms, numbers = [], {}
    for payload, at_ns in received:
        for _, message in wire.decode(payload):
            if isinstance(message, wire.Frame):
                late_ms.append(at_ns / 1e6 - message.time_us / 1e3)
                numbers.setdefault(message.node, set()).add(message.frame)
    lost = sum(max(each) - min(each) + 1 - len(each) for each in numbers.values())
    return {
        "messages": len(received),
        "bytes": sum(len(payload) for payload, _ in received),
        "late_ms": np.array(late_ms or [np.nan]),
        "lost": lost,
        "frames": sum(map(len, numbers.values())),
    }
