"""Patches of other tools and `halo monitor` report the same hits of a live service."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from docs import touchdesigner
from tests.clients.patchers import PureData, patch_of, start_sclang
from tests.ports import free_port

pytestmark = pytest.mark.long
HALO = Path(sys.executable).with_name("halo")
HITS = 4
PATIENCE_S = 180.0
Hit = tuple[float, ...]
"""Slot, u, v and strike in mm/s."""


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


def test_all_report_the_hits_of_the_monitor(
    stack: ExitStack, tmp_path: Path, external_program: Callable[[str], str]
) -> None:
    """A virtual drummer; each tool listens before the service starts."""
    ports = [free_port() for _ in range(4)]
    pd, sclang = pure_data(stack, tmp_path, external_program("pd"), ports[0]), None
    sclang = super_collider(stack, tmp_path, external_program("sclang"), ports[1])
    td = TouchDesigner(ports[2])
    stack.callback(td.close)
    monitor = started(stack, HALO, "monitor", "--json", "--from", f"osc://127.0.0.1:{ports[3]}")
    assert monitor.stdout is not None
    destinations = [word for port in ports for word in ("--osc", f"127.0.0.1:{port}")]
    options = ["--no-zenoh", "--no-web", "--control-port", str(free_port())]
    started(stack, HALO, "serve", "--source", "sim:drumming,seed=3", *options, *destinations)
    hits: list[Hit] = []
    for line in monitor.stdout:
        hits += downs(json.loads(line))
        if len(hits) >= HITS:
            break
    assert len(hits) >= HITS, "the monitor has ended"
    time.sleep(1.0)
    found = {"Pure Data": pd(), "SuperCollider": sclang(), "TouchDesigner": td.hits()}
    for name, theirs in found.items():
        # They may have received the next one, too.
        assert theirs[: len(hits)] == [pytest.approx(hit, rel=1e-5, abs=1e-4) for hit in hits], name


def downs(event: dict[str, Any]) -> list[Hit]:
    return [
        tuple(float(each[name]) for name in ("slot", "u", "v", "strike_mm_s"))
        for each in event.get("events", [])
        if each["kind"] == "down"
    ]


def pure_data(stack: ExitStack, folder: Path, program: str, port: int) -> Callable[[], list[Hit]]:
    patch = patch_of([f"halo {port}", "print hit"], [(0, 0, 1, 0)])
    pd = stack.enter_context(closing(PureData(program, folder, patch)))
    return lambda: [hit_of(line) for line in pd.lines() if line.startswith("hit: ")]


def super_collider(
    stack: ExitStack, folder: Path, program: str, port: int
) -> Callable[[], list[Hit]]:
    text = f"""
    Halo.new({port}).onDown = {{ |t|
        "hit: % % % %\\n".postf(t[\\slot], t[\\u], t[\\v], t[\\strike_mm_s])
    }};
    "listening".postln;
    """
    process = start_sclang(program, folder, text)
    assert process.stdout is not None
    stack.callback(process.stdout.close)
    stack.callback(process.wait)
    stack.callback(process.kill)
    lines: list[str] = []
    for line in process.stdout:
        if line.strip() == "listening":
            break
    thread = threading.Thread(target=lines.extend, args=(process.stdout,), daemon=True)
    thread.start()

    def hits() -> list[Hit]:
        process.kill()
        thread.join(10.0)
        return [hit_of(line) for line in lines if line.startswith("hit: ")]

    return hits


def hit_of(line: str) -> Hit:
    return tuple(map(float, line.split()[1:]))


class TouchDesigner:
    """Our network in the stand-in, which receives from a port."""

    def __init__(self, port: int) -> None:
        self._halo = touchdesigner.built()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(0.2)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                datagram = self._socket.recv(65_536)
            except TimeoutError:
                continue
            touchdesigner.TIME.seconds = time.monotonic()
            touchdesigner.receive(self._halo, datagram)

    def hits(self) -> list[Hit]:
        """The rows of the table; its numbers are rounded."""
        table = self._halo.op("hits")
        assert table is not None
        return [
            tuple(float(row[column]) for column in (2, 3, 4, 5))
            for row in table.rows[1:]
            if row[0] == "down"
        ]

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()


def started(stack: ExitStack, *command: object) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    end = threading.Timer(PATIENCE_S, process.kill)
    end.start()
    stack.callback(process.communicate)
    stack.callback(process.kill)
    stack.callback(end.cancel)
    return process
