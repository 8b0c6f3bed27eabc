"""What `halo bridge` adds to a frame's way: `python benchmarks/bridge.py`.

Sends frames of ten pointers at 30 a second through the real outputs to two UDP ports of this
process: directly, and by Zenoh over the loopback through a `halo bridge` in its own process. A
frame's added latency is the difference of its two arrivals. Goal: at most 1 ms at the median.
"""

from __future__ import annotations

import argparse
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from fuzzing.service import free_port

import halo_protocol as wire
import protocol
from halo_service.outputs import Carrier
from halo_service.outputs.destination import Destination, Stream
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput

PERIOD_S = 1 / 30
START_S = 30.0
MOST_ADDED_MS = 1.0
SIZE_MM = (300.0, 200.0)
WAYS = ("direct", "bridge")


def main() -> int:
    """Print a row for each format; 1 if the goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=20.0, help="for each row")
    options = parser.parse_args()
    print(f"load of the machine before: {os.getloadavg()[0]:.1f}")
    print(f"{'format':8} {'direct':>10} {'bridge':>10} {'added':>10} {'p99':>10} {'arrived':>9}")
    added = [measure(name, options.seconds) for name in ("frames", "flat", "tuio11")]
    return int(max(added) > MOST_ADDED_MS)


def measure(name: str, seconds: float) -> float:
    """Print a row of ms; return the median that the bridge adds."""
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    with ExitStack() as stack:
        ports = [stack.enter_context(listening()) for _ in WAYS]
        numbers = [port.getsockname()[1] for port in ports]
        carriers: list[Carrier] = [
            ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table"),
            OscOutput([Destination("127.0.0.1", numbers[0], Stream(name))]),
        ]
        for carrier in carriers:
            stack.enter_context(closing(carrier))
        stack.enter_context(bridge(endpoint, f"127.0.0.1:{numbers[1]}/{name}"))
        late_ms = arrivals(carriers, ports, seconds)
    both = late_ms[~np.isnan(late_ms).any(axis=1)]
    direct_ms, bridged_ms = np.median(both, axis=0)
    added_ms = both[:, 1] - both[:, 0]
    print(
        f"{name:8} {direct_ms:7.2f} ms {bridged_ms:7.2f} ms {np.median(added_ms):7.2f} ms "
        f"{np.percentile(added_ms, 99):7.2f} ms {len(both) / len(late_ms):9.1%}"
    )
    return float(np.median(added_ms))


def arrivals(carriers: list[Carrier], ports: list[socket.socket], seconds: float) -> np.ndarray:
    """Return (frames, 2) ms: when the first datagram of each frame arrived on each way."""
    send(carriers, 0)
    end_s = time.monotonic() + START_S
    number = 0
    while not select.select([ports[1]], [], [], PERIOD_S)[0]:  # until the bridge is connected
        number += 1
        send(carriers, number)
        if time.monotonic() > end_s:
            raise SystemExit("the bridge did not start")
    rows = []
    until_s = time.monotonic() + seconds
    while time.monotonic() < until_s:
        for port in ports:
            empty(port)
        number += 1
        sent_s = time.monotonic()
        send(carriers, number)
        late_s = [float("nan")] * len(ports)
        while (left_s := sent_s + PERIOD_S - time.monotonic()) > 0:
            for port in select.select(ports, [], [], left_s)[0]:
                port.recv(65_536)
                way = ports.index(port)
                if np.isnan(late_s[way]):
                    late_s[way] = time.monotonic() - sent_s
        rows.append(late_s)
    return np.array(rows) * 1e3


def send(carriers: list[Carrier], number: int) -> None:
    """Send a frame; by Zenoh first, so that no time of the direct way is in the other's."""
    time_us = round(time.time() * 1e6)
    header = replace(
        protocol.HEADER,
        node="desk",
        frame=number,
        time_s=time_us // 10**6,
        time_frac_us=time_us % 10**6,
    )
    frame = OutgoingFrame("table", SIZE_MM, header, tuple(protocol.POINTERS), (), ())
    scene = wire.Scene("desk", header.session, wire.VERSION, *SIZE_MM, 2, 1, 0, 30.0)
    for carrier in carriers:
        carrier.send(frame if number else OutgoingReport("table", scene))


def empty(port: socket.socket) -> None:
    """Receive what waits."""
    while select.select([port], [], [], 0)[0]:
        port.recv(65_536)


@contextmanager
def listening() -> Iterator[socket.socket]:
    """Open a UDP port of this machine."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        port.bind(("127.0.0.1", 0))
        yield port


@contextmanager
def bridge(endpoint: str, place: str) -> Iterator[None]:
    """Run `halo bridge`."""
    halo = Path(sys.executable).with_name("halo")
    options = ["--connect", endpoint, "--node", "desk", "--osc", place, "--no-web"]
    ports = ["--control-port", str(free_port(socket.SOCK_DGRAM))]
    with (
        tempfile.TemporaryFile() as log,
        subprocess.Popen([halo, "bridge", *options, *ports], stderr=log) as process,
    ):
        try:
            yield
        finally:
            process.send_signal(signal.SIGTERM)


if __name__ == "__main__":
    sys.exit(main())
