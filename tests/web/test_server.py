"""Browsers get the stream; slow and hostile clients delay no other client."""

from __future__ import annotations

import json
import os
import random
import socket
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from typing import Any

import pytest
from pythonosc.osc_message_builder import OscMessageBuilder
from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

import halo_protocol as wire
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.web.listener import MAX_CONNECTIONS
from halo_service.web.oscquery import Node
from halo_service.web.server import LARGEST, MAX_CLIENTS, WebServer
from halo_service.web.settings import WebSettings
from halo_service.web.subscriber import JSON, OSC, QUEUE
from tests.outputs.samples import TOUCHING, fingers, frame
from tests.ports import free_port

SCENE = OutgoingReport("table", wire.Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0))
DOWN = wire.Down(7, 0, 0.5, 0.25, 210.0, 5.0, 3)


@pytest.fixture
def server() -> Iterator[WebServer]:
    port = free_port()
    with closing(WebServer(WebSettings(port=port))) as server:
        yield server


def client(server: WebServer, *protocols: str, **options: Any) -> ClientConnection:
    wanted = [Subprotocol(each) for each in protocols] or None
    return connect(server.url, subprotocols=wanted, compression=None, **options)


def wait_for_clients(server: WebServer, count: int) -> None:
    until = time.monotonic() + 10.0
    while len(server._clients) != count:
        assert time.monotonic() < until, f"{len(server._clients)} clients, not {count}"
        time.sleep(0.01)


def test_binary_messages_are_the_datagrams(server: WebServer) -> None:
    with client(server, OSC) as socket_:
        wait_for_clients(server, 1)
        large = frame(1, fingers(12))
        server.send(large)
        assert [socket_.recv(5.0) for _ in large.datagrams] == large.datagrams
        assert len(large.datagrams) == 2
        (listed,) = server.clients
        assert listed.address == "127.0.0.1:{1}".format(*socket_.local_address)
        assert (listed.messages, listed.bytes) == (2, sum(map(len, large.datagrams)))


@pytest.mark.parametrize("protocols", [(JSON,), ()])
def test_text_messages_are_the_json_view(server: WebServer, protocols: tuple[str, ...]) -> None:
    with client(server, *protocols) as socket_:
        wait_for_clients(server, 1)
        server.send(frame(1, (TOUCHING,), (DOWN,)))
        view = json.loads(socket_.recv(5.0))
    assert view["kind"] == "frame" and view["surface"] == "table"
    assert (view["node"], view["count"], view["session_ms"]) == ("desk", 1, 33)
    assert view["time_us"] == 1_700_000_000_033_333
    assert view["pointers"][0] == wire.to_json(TOUCHING)
    assert view["events"] == [{"kind": "down", **wire.to_json(DOWN)}]


def test_a_late_joiner_gets_the_scene_at_once(server: WebServer) -> None:
    server.send(SCENE)
    server.send(frame(1))
    with client(server, OSC) as socket_:
        assert socket_.recv(5.0) == SCENE.datagrams[0]


@pytest.mark.parametrize(
    ("headers", "says"),
    [
        ({"Origin": "https://evil.example"}, "[web] origins"),
        ({"Origin": "null"}, "[web] origins"),
        ({"Host": "evil.example"}, "[web] hosts"),
    ],
)
def test_foreign_pages_are_refused(server: WebServer, headers: dict[str, str], says: str) -> None:
    if "Host" in headers:
        assert says in answer_to(server, host=headers["Host"])
        return
    with pytest.raises(InvalidStatus) as refused, client(server, additional_headers=headers):
        pass
    assert refused.value.response.status_code == 403
    assert says in refused.value.response.body.decode()


def answer_to(server: WebServer, host: str, path: str = "/halo") -> str:
    with socket.create_connection(("127.0.0.1", server.port), 5.0) as raw:
        raw.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n".encode())
        return b"".join(iter(lambda: raw.recv(4096), b"")).decode()


def test_a_browser_that_opens_the_address_gets_a_sentence(server: WebServer) -> None:
    answer = answer_to(server, "localhost")
    assert answer.startswith("HTTP/1.1 426 ")
    assert f"subprotocols {JSON}, {OSC}" in answer


def test_a_slow_client_loses_frames_and_delays_no_other(server: WebServer) -> None:
    big = [frame(n, fingers(64)) for n in range(3000)]
    with client(server, OSC, max_queue=1) as slow, client(server, OSC) as quick:
        wait_for_clients(server, 2)
        got: list[bytes] = []
        reader = threading.Thread(target=read_all, args=(quick, got))
        reader.start()
        longest_s = 0.0
        for each in big:
            started_s = time.monotonic()
            server.send(each)
            longest_s = max(longest_s, time.monotonic() - started_s)
            time.sleep(0.001)
        server.send(frame(9999))
        reader.join(30.0)
        assert got[-1] == frame(9999).datagrams[0]
        (lagging,) = [each for each in server._clients if each.dropped > 1000]
        assert len(lagging._queue) <= QUEUE
        # The newest is still there for it, once it reads on.
        last = b""
        with suppress(TimeoutError):
            while last != frame(9999).datagrams[0]:
                last = bytes(slow.recv(5.0))  # type: ignore[arg-type]
        assert last == frame(9999).datagrams[0]
    assert longest_s < 0.5, "a frame waited for a client"


def read_all(socket_: ClientConnection, got: list[bytes]) -> None:
    end = frame(9999).datagrams[0]
    with suppress(TimeoutError):
        while not got or got[-1] != end:
            got[:] = [bytes(socket_.recv(20.0))]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        (b"Host: \xe9vil", b"403"),
        (b"Host: localhost\r\nOrigin: http://\xff", b"403"),
        (b"Host: localhost\r\nSec-WebSocket-Protocol: halo.2.osc", b"400"),
        (b"Host: localhost\r\nSec-WebSocket-Key: \xe4", b"426"),
        (b"Host: localhost\r\nContent-Length: -1", b"400"),
        (b"Host: localhost\r\nTransfer-Encoding: chunked\r\n\r\nx", b"400"),
        (b"Host: localhost\r\nX: " + b"A" * 20_000, b"400"),
    ],
)
def test_a_bad_request_gets_its_status_and_no_line_in_the_log(
    server: WebServer, headers: bytes, status: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    upgrade = b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    with socket.create_connection(("127.0.0.1", server.port), 5.0) as raw:
        raw.sendall(b"GET /halo HTTP/1.1\r\n" + upgrade + headers + b"\r\n\r\n")
        assert status in raw.recv(4096).partition(b"\r\n")[0]
    assert caplog.text == ""


def test_an_unexpected_error_of_a_request_is_logged_once(
    server: WebServer, caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> list[Node]:
        raise RuntimeError("out of order")

    server.nodes = fail
    for _ in range(3):
        with (
            pytest.raises(urllib.error.HTTPError) as failed,
            urllib.request.urlopen(f"http://127.0.0.1:{server.port}/", timeout=10.0),
        ):
            pass
        with closing(failed.value):
            assert failed.value.code == 500
    assert caplog.text.count("RuntimeError: out of order") == 1


def test_random_bytes_and_messages_end_only_their_connection(server: WebServer) -> None:
    chance = random.Random(1)
    with client(server, OSC) as good:
        wait_for_clients(server, 1)
        for _ in range(200):
            with (
                suppress(OSError),
                socket.create_connection(("127.0.0.1", server.port), 5.0) as raw,
            ):
                raw.sendall(os.urandom(chance.randrange(1, 300)))
        for n in range(30):
            with suppress(WebSocketException, OSError), client(server) as bad:
                bad.send(os.urandom(chance.randrange(1, 2 * LARGEST)))
                bad.recv(0.05)
            server.send(frame(n))
            assert good.recv(5.0) == frame(n).datagrams[0]
    wait_for_clients(server, 0)


def test_the_number_of_clients_is_bounded(server: WebServer) -> None:
    with ExitStack() as stack:
        for _ in range(MAX_CLIENTS):
            stack.enter_context(client(server, OSC))
        wait_for_clients(server, MAX_CLIENTS)
        with pytest.raises(InvalidStatus) as refused, client(server):
            pass
        assert refused.value.response.status_code == 503


def test_the_number_of_connections_is_bounded(server: WebServer) -> None:
    with ExitStack() as stack:
        idle = [
            stack.enter_context(socket.create_connection(("127.0.0.1", server.port), 5.0))
            for _ in range(MAX_CONNECTIONS + 10)
        ]
        assert [each.recv(1) for each in idle[-10:]] == [b""] * 10, "they are closed at once"
    until = time.monotonic() + 10.0
    while time.monotonic() < until:
        with suppress(OSError, WebSocketException), client(server, OSC):
            return
    pytest.fail("no client is served after the others have left")


def test_requests_whose_body_never_comes_leave_nothing_behind(server: WebServer) -> None:
    for _ in range(20):
        with socket.create_connection(("127.0.0.1", server.port), 5.0) as raw:
            raw.sendall(b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n")
            assert raw.recv(4096).startswith(b"HTTP/1.1 405")
    until = time.monotonic() + 10.0
    while server._runner.server.connections:
        assert time.monotonic() < until, "connections are still counted"
        time.sleep(0.02)


def test_a_port_in_use_is_replaced_by_a_free_one(
    server: WebServer, caplog: pytest.LogCaptureFixture
) -> None:
    with closing(WebServer(WebSettings(port=server.port))) as other:
        assert other.port != server.port
        assert f"port {server.port} is in use, so this service uses {other.port}" in caplog.text
        with client(other, OSC):
            wait_for_clients(other, 1)


@pytest.mark.parametrize("host", ["192.0.2.1", "no.such.host.invalid"])
def test_a_host_of_another_machine_is_one_sentence(host: str) -> None:
    with pytest.raises(UserError, match=r"set \[web\] host to an address of this machine"):
        WebServer(WebSettings(host=host))


def test_the_url_of_a_server_that_is_open_to_all_works_on_this_machine() -> None:
    port = free_port()
    with closing(WebServer(WebSettings(host="0.0.0.0", port=port))) as server:
        assert server.url == f"ws://127.0.0.1:{port}/halo"
        server.send(SCENE)
        with client(server, OSC) as socket_:
            assert socket_.recv(5.0) == SCENE.datagrams[0]


def test_closing_says_goodbye_to_clients() -> None:
    server = WebServer(WebSettings(port=4258))
    with client(server, OSC) as socket_:
        wait_for_clients(server, 1)
        ended = threading.Thread(target=server.close)
        ended.start()
        with pytest.raises(WebSocketException, match="1001"):
            socket_.recv(5.0)
        ended.join(10.0)
    assert not server._thread.is_alive()


def control(address: str, *arguments: object) -> str:
    return json.dumps(
        {"kind": "control", "address": f"/halo/1/control/{address}", "arguments": arguments}
    )


@pytest.mark.parametrize(
    ("protocol", "version", "stream", "outcome"),
    [
        (JSON, "1.0.0", "frames", "accepted"),
        (JSON, "1.0.7", "frames,rate=10", "accepted"),
        (JSON, "1.0.0", "flat", "refused"),
        (JSON, "2.0.0", "frames", "refused"),
        (JSON, "1.1.0", "frames", "refused"),
        (JSON, "1.0.0", "midi", "refused"),
        (OSC, "1.0.0", "flat", "accepted"),
        (OSC, "0.9.0", "flat", "refused"),
    ],
)
def test_a_hello_is_judged_and_a_refused_client_is_disconnected(
    protocol: str, version: str, stream: str, outcome: str
) -> None:
    with closing(WebServer(WebSettings(), "desk", "s1")) as server, client(server, protocol) as c:
        if protocol == JSON:
            c.send(control("hello", version, stream))
            answer = json.loads(c.recv(5.0))
            address, arguments = answer["address"], answer["arguments"]
        else:
            c.send(osc_message("/halo/1/control/hello", version, stream))
            ((address, arguments),) = wire.parse_osc(bytes(c.recv(5.0)))  # type: ignore[arg-type]
        assert address == "/halo/1/control/welcome"
        assert list(arguments[:4]) == ["desk", "s1", wire.VERSION, outcome]
        if outcome == "refused":
            with pytest.raises(WebSocketException):
                c.recv(5.0)


def osc_message(address: str, *arguments: str) -> bytes:
    builder = OscMessageBuilder(address)
    for argument in arguments:
        builder.add_arg(argument)
    return bytes(builder.build().dgram)


def test_clients_have_streams_of_their_own(server: WebServer) -> None:
    with client(server, OSC) as flat, client(server, JSON) as other, client(server, JSON) as all_:
        flat.send(osc_message("/halo/1/control/hello", "1.0.0", "flat"))
        other.send(control("hello", "1.0.0", "frames,surface=wall"))
        assert b"welcome" in bytes(flat.recv(5.0))  # type: ignore[arg-type]
        assert json.loads(other.recv(5.0))["arguments"][3] == "accepted"
        wait_for_clients(server, 3)
        server.send(frame(1, (TOUCHING,)))
        addresses = [each for each, _ in wire.parse_osc(bytes(flat.recv(5.0)))]  # type: ignore[arg-type]
        assert "/halo/1/table/slot/0/u" in addresses
        assert json.loads(all_.recv(5.0))["kind"] == "frame"
        with pytest.raises(TimeoutError):
            other.recv(0.2)


def test_commands_reach_the_service_and_answers_the_client() -> None:
    got: list[ControlMessage] = []

    def answer(message: ControlMessage) -> None:
        got.append(message)
        message.answer(osc_message("/halo/1/control/status", "desk"))

    with closing(WebServer(WebSettings(), control=answer)) as server, client(server, JSON) as c:
        c.send(control("sensing/hover_range_mm", 55.5))
        assert json.loads(c.recv(5.0)) == {
            "kind": "control", "address": "/halo/1/control/status", "arguments": ["desk"],
        }  # fmt: skip
    (message,) = got
    assert message.address == "/halo/1/control/sensing/hover_range_mm"
    assert (message.arguments, message.sender[0]) == ((55.5,), "127.0.0.1")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[" * 3000,
        "1",
        '{"kind": "control"}',
        '{"kind": "control", "address": 1}',
        '{"kind": "control", "address": "/a\\u0000"}',
        '{"kind": "control", "address": "/a", "arguments": {}}',
        '{"kind": "control", "address": "/a", "arguments": [[1]]}',
        '{"kind": "control", "address": "/a", "arguments": [NaN]}',
        '{"kind": "control", "address": "/a", "arguments": [99999999999]}',
        '{"kind": "control", "address": "/a", "arguments": ["\\ud800"]}',
    ],
)
def test_a_bad_message_is_skipped(text: str) -> None:
    got: list[ControlMessage] = []
    with (
        closing(WebServer(WebSettings(), control=got.append)) as server,
        client(server, JSON) as c,
    ):
        c.send(text)
        c.send(control("pause"))
        until = time.monotonic() + 5.0
        while not got and time.monotonic() < until:
            time.sleep(0.01)
    assert [each.address for each in got] == ["/halo/1/control/pause"]
