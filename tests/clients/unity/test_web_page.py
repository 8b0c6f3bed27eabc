"""The WebSocket of the Unity client's WebGL builds, in Node with a memory as Emscripten has it."""

from __future__ import annotations

import subprocess
import threading
from pathlib import Path

from websockets.sync.server import ServerConnection, serve

from tests.clients.unity.conftest import PACKAGE
from tests.clients.web.test_page import NODE, needs_node

JSLIB = PACKAGE / "Runtime" / "Plugins" / "WebGL" / "HaloWebSocket.jslib"
SCRIPT = Path(__file__).with_name("jslib.mjs")
LARGEST = 65_507
pytestmark = needs_node


def received(url: str) -> list[str]:
    command = [*NODE, str(SCRIPT), str(JSLIB), url]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_messages_arrive_as_bytes() -> None:
    """Texts, and what is larger than a datagram, are skipped."""
    sent = [bytes([n, 0, 255 - n]) * (1 + 40 * n) for n in range(100)]

    def send(client: ServerConnection) -> None:
        assert client.request is not None
        for each in (*sent, "text", bytes(LARGEST + 1), b"end"):
            client.send(each)

    with serve(send, "127.0.0.1", 0, subprotocols=["halo.1.osc"]) as server:  # type: ignore[list-item]
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        found = received(f"ws://127.0.0.1:{server.socket.getsockname()[1]}/halo")
        server.shutdown()
        thread.join()
    assert found == [each.hex() for each in (*sent, b"end")]


def test_a_page_that_reads_late_gets_the_newest() -> None:
    assert received("flood") == [n.to_bytes(2, "big").hex() for n in range(1000 - 128, 1000)]
