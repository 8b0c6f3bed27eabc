"""What many clients cost a frame, and how late they get it: `python benchmarks/outputs.py`.

Sends frames of ten pointers at 30 a second through the real outputs, after some work as sensing
does it, to 50 UDP destinations, 50 WebSocket clients and 50 Zenoh clients in other processes. What
the clients add is the difference of the median time of work and sending. Encoding comes first, as
in `benchmarks/protocol.py`. Goals: 50 us a frame, 150 us in all formats; 2 ms for all clients; 1 ms
from publishing to a Zenoh subscriber.
"""

from __future__ import annotations

import argparse
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import numpy as np
from fuzzing.service import free_port

import protocol
from halo_service.outputs import Carrier
from halo_service.outputs.destination import Destination
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import OutgoingFrame
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings

RECEIVERS = Path(__file__).with_name("receivers.py")
PERIOD_S = 1 / 30
IMAGE = np.random.default_rng(1).integers(0, 1000, (288, 320)).astype(np.uint16)
ALL = ["udp", "websocket", "zenoh"]
ROWS = (["zenoh 1"], ["udp"], ["websocket"], ["json"], ["zenoh"], ALL)
MOST_ADDED_MS, MOST_ZENOH_MS = 2.0, 1.0


@dataclass
class Clients:
    """Clients of one kind."""

    kind: str
    process: subprocess.Popen[str]
    ports: list[int]
    """Of UDP."""


def main() -> int:
    """Print both tables; 1 if a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=10.0, help="for each row")
    parser.add_argument("--clients", type=int, default=50, help="of each kind")
    options = parser.parse_args()
    missed = protocol.main()
    print(f"\nload of the machine before: {os.getloadavg()[0]:.1f}")
    print(f"{'clients':30} {'frame':>9} {'added':>9}   datagrams got, late (median, p99)")
    alone_ms = measure([], 0, options.seconds, None)
    for kinds in ROWS:
        count = 1 if kinds == ["zenoh 1"] else options.clients
        names = [kind.split()[0] for kind in kinds]
        added_ms, zenoh_ms = measure(names, count, options.seconds, alone_ms[0])
        missed += added_ms > MOST_ADDED_MS
        missed += kinds == ["zenoh 1"] and zenoh_ms > MOST_ZENOH_MS
    measure([], 0, options.seconds, alone_ms[0])
    return int(missed > 0)


def measure(
    kinds: Sequence[str], count: int, seconds: float, alone_ms: float | None
) -> tuple[float, float]:
    """Print a row; return ms that a frame costs more, or costs alone, and how late Zenoh is."""
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    with ExitStack() as stack:
        web = stack.enter_context(
            closing(WebServer(WebSettings(port=free_port(socket.SOCK_STREAM))))
        )
        zenoh = ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table")
        stack.enter_context(closing(zenoh))
        places = {"udp": "-", "websocket": web.url, "json": web.url, "zenoh": endpoint}
        clients = [stack.enter_context(started(kind, count, places[kind])) for kind in kinds]
        ports = [port for each in clients for port in each.ports]
        osc = OscOutput([Destination("127.0.0.1", port) for port in ports])
        stack.enter_context(closing(osc))
        frame_ms, frames, sent = publish([osc, zenoh, web], seconds)
        name = ", ".join(f"{count} {kind}" for kind in kinds) or "none"
        added_ms = frame_ms - (alone_ms or 0.0)
        print(f"{name:30} {frame_ms:6.2f} ms {added_ms if alone_ms else 0.0:6.2f} ms", end="  ")
        late = {
            each.kind: result(each, frames if each.kind == "json" else sent) for each in clients
        }
        print()
    return added_ms, late.get("zenoh", 0.0)


@contextmanager
def started(kind: str, count: int, place: str) -> Iterator[Clients]:
    """Start clients of one kind in a process, and end them."""
    command = [sys.executable, str(RECEIVERS), kind, str(count), place]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        assert process.stdout is not None
        try:
            ports = json.loads(process.stdout.readline()) if kind == "udp" else []
            process.stdout.readline()
            yield Clients(kind, process, ports)
        finally:
            process.kill()


def publish(carriers: Sequence[Carrier], seconds: float) -> tuple[float, int, int]:
    """Send; return the median ms of work and sending, and the number of frames and datagrams."""
    spent_ms: list[float] = []
    number = sent = 0
    until_s = next_s = time.monotonic()
    until_s += seconds
    while next_s < until_s:
        time.sleep(max(0.0, next_s - time.monotonic()))
        next_s += PERIOD_S
        number += 1
        started_s = time.monotonic()
        work()
        time_us = round(time.monotonic() * 1e6)
        header = replace(
            protocol.HEADER, frame=number, time_s=time_us // 10**6, time_frac_us=time_us % 10**6
        )
        frame = OutgoingFrame("table", (300.0, 200.0), header, tuple(protocol.POINTERS), (), ())
        for carrier in carriers:
            carrier.send(frame)
        sent += len(frame.datagrams)
        spent_ms.append((time.monotonic() - started_s) * 1e3)
    return median(spent_ms), number, sent


def work() -> None:
    """Do some milliseconds of Python and NumPy, as sensing does."""
    for _ in range(4):
        np.partition(IMAGE, 1000, axis=None)
        sum(n * n for n in range(2_000))


def result(clients: Clients, sent: int) -> float:
    """Print what clients got; return how late, median ms."""
    said, _ = clients.process.communicate(timeout=60.0)
    found = json.loads(said)
    share = min(found["frames"]) / sent
    print(f"{clients.kind} {share:.0%}, {found['ms']:.2f}, {found['p99_ms']:.1f} ms;", end=" ")
    return float(found["ms"])


if __name__ == "__main__":
    sys.exit(main())
