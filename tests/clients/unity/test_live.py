"""The Unity client's core on real sockets: conformance, a running service, what it allocates."""

from __future__ import annotations

import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import encode
from halo_service.app.conformance.expected import verdict
from halo_service.app.conformance.play import play_udp, play_websocket
from halo_service.app.conformance.script import down, frame, steps, touching
from tests.clients.unity.test_sources import REPORTS
from tests.ports import free_port

Line = dict[str, Any]
HALO = Path(sys.executable).with_name("halo")
SOURCE = "sim:ten-fingers?mode=NFOV_2X2BINNED"


class Client:
    """A program that writes a line of JSON for each event, until its input ends."""

    def __init__(self, command: list[str]) -> None:
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._lines: list[Line] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.append(json.loads(line))

    def wait_until_ready(self) -> None:
        assert self._process.stderr is not None
        assert self._process.stderr.readline() == "ready\n"

    def lines(self) -> list[Line]:
        """What has come until now."""
        assert self._process.poll() in (None, 0)
        return self._lines.copy()

    def end(self) -> list[Line]:
        """Our program ends with its input, and `halo monitor` with Ctrl-C."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        if "monitor" in self._process.args:
            self._process.send_signal(signal.SIGINT)
        self._process.wait(20.0)
        self._reader.join()
        for pipe in (self._process.stdout, self._process.stderr):
            assert pipe is not None
            pipe.close()
        return self.lines()

    def kill(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self.end()


@pytest.fixture
def start() -> Iterator[Callable[..., Client]]:
    with ExitStack() as clients:

        def run(*command: str) -> Client:
            client = Client(list(command))
            clients.callback(client.kill)
            return client

        yield run


def differences(lines: list[Line]) -> list[str]:
    return [f"{node}: {why}" for node, _, why in verdict(lines) if why]


def in_thread(action: Callable[..., object], *arguments: Any) -> threading.Thread:
    thread = threading.Thread(target=action, args=arguments, daemon=True)
    thread.start()
    return thread


@pytest.mark.long
def test_it_passes_the_conformance_test(program: list[str], start: Callable[..., Client]) -> None:
    """By UDP, and by the WebSocket of the editor and desktop builds, at the same time."""
    osc, web = free_port(), free_port()
    by_udp = start(*program, "live", f"osc://127.0.0.1:{osc}?follow=all")
    by_udp.wait_until_ready()
    opened = threading.Event()
    players = [
        in_thread(play_udp, "127.0.0.1", osc),
        in_thread(play_websocket, web, lambda url: opened.set()),
    ]
    assert opened.wait(20)
    by_websocket = start(*program, "live", f"ws://127.0.0.1:{web}/halo?follow=all")
    for player in players:
        player.join()
    assert differences(by_udp.end()) == []
    assert differences(by_websocket.end()) == []


class Relay:
    """Forwards a service's datagrams to several clients, with the same losses for each."""

    def __init__(self, targets: list[int]) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.2)
        self.port = int(self._socket.getsockname()[1])
        self._targets = targets
        self._over = threading.Event()
        self._thread = in_thread(self._run)

    def _run(self) -> None:
        chance = random.Random(17)
        held: bytes | None = None
        while not self._over.is_set():
            try:
                datagram = self._socket.recv(65_536)
            except TimeoutError:
                continue
            kind = chance.random()
            if kind < 0.1:
                continue  # lost
            if kind < 0.15 and held is None:
                held = datagram  # late
                continue
            for each in (datagram, *([datagram] if kind > 0.95 else []), *([held] if held else [])):
                for port in self._targets:
                    self._socket.sendto(each, ("127.0.0.1", port))
            held = None

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()


@pytest.mark.long
def test_it_prints_the_frames_of_halo_monitor(
    program: list[str], start: Callable[..., Client], tmp_path: Path
) -> None:
    """A running service, killed and started again; lost, late, doubled and split datagrams."""
    ours, monitors = free_port(), free_port()
    relay = Relay([ours, monitors])
    settings = tmp_path / "halo.toml"
    # Ten fingers do not fit a bundle of 768 bytes.
    settings.write_text('[osc]\nmax_bytes = 768\n[sensing]\nfingers = "all"\n')

    def serve() -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [
                HALO, "serve", "--config", settings, "--node", "desk", "--no-zenoh", "--no-web",
                "--osc", f"127.0.0.1:{relay.port}", "--control-port", str(free_port()),
                "--source", SOURCE,
            ],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    # `halo monitor` shows all services.
    unity = start(*program, "live", f"osc://127.0.0.1:{ours}?follow=all")
    monitor = start(str(HALO), "monitor", "--json", "--from", f"osc://127.0.0.1:{monitors}")
    unity.wait_until_ready()
    wait_for(lambda: is_bound(monitors))
    service = serve()
    try:
        wait_for(lambda: split_frames(unity) > 40 and touches(unity) > 0)
        service.kill()
        service.wait()
        first = unity.lines()[-1]["session"]
        service = serve()
        wait_for(lambda: split_frames(unity, but=first) > 10)
    finally:
        service.kill()
        service.wait()
        relay.close()
    # Both end the touches of the lost service.
    wait_for(lambda: losses(unity) == 2 and losses(monitor) == 2)
    found, expected = unity.end(), monitor.end()
    for line in expected:
        del line["received_us"]
    assert by_session(found) == by_session(expected)
    frames = [line for line in found if line["kind"] == "frame"]
    assert sum(line["missed"] for line in frames) > 5
    assert any(not line["complete"] for line in frames), "a part of a split frame was lost"


def split_frames(client: Client, but: str = "") -> int:
    """Frames with too many fingers for a bundle, of other sessions than one."""
    frames = (line for line in client.lines() if line["kind"] == "frame" and line["session"] != but)
    return sum(len(line["pointers"]) > 5 for line in frames)


def by_session(lines: list[Line]) -> dict[str, list[Line]]:
    """A session is lost after 3 s: which line of another one comes before is a matter of ms."""
    sessions: dict[str, list[Line]] = {}
    for line in lines:
        sessions.setdefault(line["session"], []).append(line)
    return sessions


def losses(client: Client) -> int:
    return sum(line["kind"] == "lost" for line in client.lines())


def touches(client: Client) -> int:
    return sum(len(line.get("events", ())) for line in client.lines())


def is_bound(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return True
    return False


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, "it did not happen in time"
        time.sleep(0.1)


@pytest.mark.long
def test_a_requested_stream_arrives_and_allocates_nothing(
    program: list[str], tmp_path: Path
) -> None:
    """From a running sender, requested by a hello; the lease is renewed meanwhile."""
    control = free_port()
    settings = tmp_path / "halo.toml"
    settings.write_text(
        f"[control]\nport = {control}\n[osc]\nenabled = false\n[zenoh]\nenabled = false\n"
        f"[web]\nport = {free_port()}\n"
    )
    url = f"osc://?hello=127.0.0.1:{control}"
    command = [HALO, "test-pattern", "--config", settings, "--seconds", "30"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as sender:
        done = measure([*program, "allocations", url, "60"])
        sender.terminate()
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"frames": 60, "bytes": 0, "collections": 0}


def measure(
    command: list[str], environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run it; each path of the code runs once before."""
    sent = [step.datagram.hex() for step in steps() if step.datagram is not None]
    reports = [encode("table", each).hex() for each in REPORTS]
    return subprocess.run(
        command,
        env=environment,
        input="".join(f"{raw}\n" for raw in (*sent, *reports)),
        capture_output=True,
        text=True,
        timeout=60,
    )


FLOOD = 10_000


@pytest.mark.long
def test_no_thread_allocates_for_a_datagram(program: list[str]) -> None:
    """The smallest object has 16 bytes; one for each datagram would fill a nursery of 64 kB."""
    port = free_port()
    over = threading.Event()

    def send() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            number = 0
            while not over.wait(0.001):
                for _ in range(8):
                    number += 1
                    for raw in frame("desk", number, [touching()], [down()]):
                        sender.sendto(raw, ("127.0.0.1", port))

    command = [*program, "allocations", f"osc://127.0.0.1:{port}", str(FLOOD)]
    environment = {**os.environ, "MONO_GC_PARAMS": "nursery-size=64k"}
    sender = in_thread(send)
    try:
        done = measure(command, environment)
    finally:
        over.set()
        sender.join()
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"frames": FLOOD, "bytes": 0, "collections": 0}
