"""`connect` to a service: it requests the stream, finds the service again, reports touches."""

from __future__ import annotations

import itertools
import json
import logging
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

import halo_client
import halo_protocol as wire
from halo_client import ClientError, Receiver
from halo_client.lease import Lease
from halo_protocol.handshake import EXPIRED, LEASE, LEAST_HELLO, WELCOME, with_token
from halo_protocol.osc import padded
from halo_service.outputs.control import ControlMessage, ControlPort
from halo_service.outputs.leases import Leases
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import OutgoingFrame
from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings
from tests.outputs.samples import TOUCHING

pytestmark = pytest.mark.slow

DOWN = wire.Down(TOUCHING.id, 0, 0.5, 0.25, 210.0, 5.0, TOUCHING.contacts)
NEVER = threading.Event()
"""The finger stays away."""


def touch(number: int, since: int, session: str) -> OutgoingFrame:
    """A frame; `since`: for how many frames the finger is down, 0 is none."""
    pointers = (TOUCHING,) if since else ()
    header = wire.Frame("desk", session, number, *divmod(number * 20_000, 10**6), len(pointers))
    downs = (DOWN,) if 1 <= since <= 3 else ()
    return OutgoingFrame("table", (300.0, 200.0), header, pointers, downs, ())


@contextmanager
def sending(
    send: Callable[[OutgoingFrame], Any], session: str, press: threading.Event
) -> Iterator[None]:
    """Frames 50 times a second; the finger comes down when `press` is set, and stays."""
    over = threading.Event()

    def run() -> None:
        since = 0
        for number in itertools.count():
            since += press.is_set()
            send(touch(number, since, session))
            if over.wait(0.02):
                return

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def on_request(port: int, session: str = "s1", press: threading.Event = NEVER) -> Iterator[Leases]:
    """A service that streams to those that say hello."""
    leases = Leases("desk", session, ("127.0.0.0/8",))
    with closing(ControlPort("127.0.0.1", port)) as control, closing(OscOutput([])) as osc:

        def send(outgoing: OutgoingFrame) -> None:
            for message in control.drain():
                for reply in leases.handle(message, time.monotonic()):
                    control.reply(*reply)
            osc.set_leased(leases.destinations)
            osc.send(outgoing)

        with sending(send, session, press):
            yield leases


@contextmanager
def web(port: int, session: str = "s1", press: threading.Event = NEVER) -> Iterator[WebServer]:
    with closing(WebServer(WebSettings(port=port))) as server, sending(server.send, session, press):
        yield server


def collect(receiver: Receiver) -> list[tuple[str, str]]:
    """What the callbacks report: (what, session), without repeated moves."""
    found: list[tuple[str, str]] = []

    def moved(each: halo_client.Moved) -> None:
        if found[-1:] != [("move", each.key.session)]:
            found.append(("move", each.key.session))

    receiver.on_down(lambda each: found.append(("down", each.key.session)))
    receiver.on_move(moved)
    receiver.on_up(lambda each: found.append(("up", each.key.session)))
    return found


def run_until(receiver: Receiver, done: Callable[[], object]) -> None:
    until = time.monotonic() + 15.0
    while not done():
        assert time.monotonic() < until, "nothing came"
        receiver.run(0.1)


@pytest.mark.parametrize(
    ("url", "service"),
    [("osc://?hello=127.0.0.1:{}", on_request), ("ws://127.0.0.1:{}/halo", web)],
    ids=["osc", "ws"],
)
def test_a_restarted_service_is_found_again_and_its_touches_end(
    url: str, service: Any, free_tcp_port: int
) -> None:
    with halo_client.connect(url.format(free_tcp_port)) as receiver:
        found = collect(receiver)
        receiver.run(0.3)
        assert found == [], "there is no service yet"
        for session in ("s1", "s2"):
            with service(free_tcp_port, session, press := threading.Event()):
                run_until(receiver, lambda: receiver.following)
                press.set()
                run_until(receiver, lambda: found and found[-1][0] == "move")
            run_until(receiver, lambda: found[-1][0] == "up")
    steps = [(step, session) for session in ("s1", "s2") for step in ("down", "move", "up")]
    assert found == steps


def test_a_closed_client_ends_its_stream(free_port: int) -> None:
    with on_request(free_port) as leases:
        with halo_client.connect(f"osc://?hello=127.0.0.1:{free_port}") as receiver:
            run_until(receiver, lambda: receiver.following)
            assert len(leases.destinations) == 1
        until = time.monotonic() + 5.0
        while leases.destinations and time.monotonic() < until:
            time.sleep(0.01)
    assert leases.destinations == []


def test_a_refusal_is_one_sentence(free_port: int) -> None:
    url = f"osc://?hello=127.0.0.1:{free_port}&rate=fast"
    with (
        on_request(free_port),
        halo_client.connect(url) as receiver,
        pytest.raises(ClientError, match=r"refuses: .*rate must be a number of frames"),
    ):
        receiver.run(5.0)


def test_an_unknown_name_is_one_sentence() -> None:
    with pytest.raises(ClientError, match=r"no address of 'nowhere\.invalid' is found"):
        halo_client.connect("osc://?hello=nowhere.invalid")


def test_a_refusal_of_another_program_changes_nothing(free_port: int) -> None:
    refusal = padded(WELCOME) + padded(",ssssss") + b"".join(map(padded, ["", "", "", "refused"]))
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as forger,
        halo_client.connect(f"osc://127.0.0.1:0?hello=127.0.0.1:{free_port}") as receiver,
    ):
        port = int(receiver.url.split(":")[2].split("?")[0])
        forger.sendto(refusal + padded("") + padded("no"), ("127.0.0.1", port))
        receiver.run(0.2)


def welcome(token: str) -> bytes:
    raw = Leases("desk", "s1", ("127.0.0.0/8",), lambda: token)
    message = ControlMessage(
        "/halo/1/control/hello", ("1.0.0", "frames", 0), ("127.0.0.1", 9), LEAST_HELLO
    )
    (reply,) = raw.handle(message, 0.0)
    return reply.datagram


def test_a_lease_is_renewed_every_three_seconds_and_asked_for_again() -> None:
    lease = Lease("frames", "here")
    first = lease.due(0.0)
    assert first is not None and len(first) >= LEAST_HELLO
    assert lease.due(0.9) is None and lease.due(1.0) == first
    assert lease.handle(welcome("t1"))
    renewed = with_token(LEASE, "t1")
    assert lease.due(1.1) == renewed
    assert lease.due(4.0) is None and lease.due(4.1) == renewed
    assert lease.handle(with_token(EXPIRED, "t0")), "another token: nothing changes"
    assert lease.due(4.2) is None
    assert lease.handle(with_token(EXPIRED, "t1"))
    assert lease.due(4.2) == first


@pytest.mark.parametrize("cut", range(4, 120, 4))
def test_no_answer_of_the_control_port_raises(cut: int) -> None:
    lease = Lease("frames", "here")
    answer = welcome("t1")[:-cut]
    assert lease.handle(answer) == answer.startswith(WELCOME[:16].encode())
    assert lease.goodbye() is None


def test_why_a_websocket_refuses_is_logged_once(
    free_tcp_port: int, caplog: pytest.LogCaptureFixture
) -> None:
    # This host is not among those that the server's user allowed.
    with (
        caplog.at_level(logging.WARNING, "halo_client"),
        closing(WebServer(WebSettings(host="127.0.0.2", port=free_tcp_port))) as server,
        halo_client.connect(server.url) as receiver,
    ):
        receiver.run(1.3)
    sentences = [record.getMessage() for record in caplog.records]
    assert sentences == [
        f"cannot connect to {server.url} (this server is not '127.0.0.2:{free_tcp_port}'; "
        "add the name to [web] hosts); trying again"
    ]


def test_the_monitor_shows_a_websocket(free_tcp_port: int) -> None:
    command = [sys.executable, "-m", "halo_tools.monitor", "--json", "--frames", "3"]
    with web(free_tcp_port) as server:
        done = subprocess.run(
            [*command, "--from", server.url], capture_output=True, text=True, timeout=30
        )
    assert done.returncode == 0, done.stderr
    kinds = [json.loads(line)["kind"] for line in done.stdout.splitlines()]
    assert kinds == ["frame"] * 3


def test_callbacks_of_a_recorded_stream(tmp_path: Path) -> None:
    view: dict[str, Any] = {"node": "desk", "surface": "table", "session": "s1"}
    held = {"pointers": [wire.to_json(TOUCHING)], "events": []}
    down = {"kind": "down", **wire.to_json(DOWN)}
    lines = [
        {**view, "frame": 0, "time_us": 0, "pointers": [], "events": []},
        {**view, "frame": 1, "time_us": 10_000, **held, "events": [down]},
        {**view, "frame": 2, "time_us": 20_000, **held},
    ]
    path = tmp_path / "touch.jsonl"
    path.write_text("\n".join(map(json.dumps, lines)))
    with halo_client.connect(str(path)) as receiver:
        found = collect(receiver)
        receiver.run()
    assert found == [("down", "s1"), ("move", "s1"), ("up", "s1")]


def test_without_its_library_a_websocket_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ClientError, match=r"needs the package websockets; `uv pip install"):
        halo_client.connect("ws://127.0.0.1")
