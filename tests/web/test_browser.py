"""Chromium reads the same values from the WebSocket, in both subprotocols."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import closing

import pytest

import halo_protocol as wire
from halo_service.outputs.outgoing import Outgoing, OutgoingReport
from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings
from tests.browser import needs_chromium, visit
from tests.outputs.samples import TOUCHING, fingers, frame
from tests.ports import free_port

SCENE = wire.Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0)
DOWN = wire.Down(7, 0, 0.5, 0.25, 210.0, 5.0, 3)
SENT: list[Outgoing] = [
    OutgoingReport("table", SCENE),
    frame(1, (TOUCHING,), (DOWN,)),
    frame(2, fingers(12)),
]
PAGE = """<!doctype html><body><script type="module">
const [url, protocol, count] = decodeURIComponent(location.search.slice(1)).split(",");
const socket = new WebSocket(url, [protocol]);
socket.binaryType = "arraybuffer";
const found = [];
const digits = (byte) => byte.toString(16).padStart(2, "0");
const hex = (data) => Array.from(new Uint8Array(data), digits).join("");
socket.onmessage = ({ data }) => {
  found.push(data instanceof ArrayBuffer ? hex(data) : JSON.parse(data));
  if (found.length === Number(count)) report({ protocol: socket.protocol, found });
};
</script></body>"""


@pytest.fixture
def server() -> Iterator[WebServer]:
    """A service that sends everything once a client is there."""
    over = threading.Event()

    def run(server: WebServer) -> None:
        while not server._clients:
            if over.wait(0.02):
                return
        for each in SENT:
            server.send(each)

    port = free_port()
    with closing(WebServer(WebSettings(port=port))) as server:
        thread = threading.Thread(target=run, args=(server,))
        thread.start()
        yield server
        over.set()
        thread.join()


@needs_chromium
def test_chromium_gets_the_bundles(server: WebServer) -> None:
    expected = [datagram.hex() for each in SENT for datagram in each.datagrams]
    shown = visit({"index.html": PAGE}, f"index.html?{server.url},halo.1.osc,{len(expected)}")
    assert shown == {"protocol": "halo.1.osc", "found": expected}


@needs_chromium
def test_chromium_gets_the_json_view(server: WebServer) -> None:
    expected = [json.loads(each.text) for each in SENT]
    shown = visit({"index.html": PAGE}, f"index.html?{server.url},halo.1.json,{len(expected)}")
    assert shown == {"protocol": "halo.1.json", "found": expected}
