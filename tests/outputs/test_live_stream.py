"""Programs of other projects show the same finger, from one live stream of the real outputs.

One row per program: what it prints, as values by the names of the wire. Each is skipped where it is
not installed; `.ci/run` installs all.
"""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from pythonosc.dispatcher import Dispatcher
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_server import BlockingOSCUDPServer

from halo_protocol.table import ROW_OF_KIND
from halo_service.outputs.destination import parse_destination
from halo_service.outputs.osc import OscOutput
from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings
from tests.browser import visit
from tests.outputs.samples import TOUCHING, frame
from tests.ports import free_port

FINGER = replace(TOUCHING, u=0.3, v=0.7, x_mm=90.0, y_mm=140.0, pressure=0.42, vx_mm_s=-15.0)
NAMES = [field.name for field in ROW_OF_KIND["pointer"].fields]
FLOATS = [field.name for field in ROW_OF_KIND["pointer"].fields if field.tag == "f"]
PATIENCE_S = 60.0
PERIOD_S = 1 / 30
FRAMES = ("oscdump", "pd", "sclang", "python-osc", "pyliblo3", "tshark")
"""Programs that receive the format `frames`, each on a port of its own."""
HERE = Path(__file__).parent
TUIO = HERE / "tuio_client"
OSCQUERY = HERE.parent / "web" / "oscquery_client"


@dataclass
class Live:
    """The stream, and where each program receives it."""

    ports: dict[str, int]
    url: str
    folder: Path
    programs: Callable[[str], str]

    def lines(self, *command: str) -> Iterator[str]:
        """What a program prints, until the caller has seen enough."""
        with subprocess.Popen(
            [self.programs(command[0]), *command[1:]],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        ) as program:  # fmt: skip
            assert program.stdout is not None
            end = threading.Timer(PATIENCE_S, program.kill)
            end.start()
            try:
                yield from program.stdout
            finally:
                end.cancel()
                program.kill()

    def datagrams(self, name: str, count: int) -> list[bytes]:
        """Some datagrams from one port."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
            receiver.bind(("127.0.0.1", self.ports[name]))
            receiver.settimeout(PATIENCE_S)
            return [receiver.recv(65_536) for _ in range(count)]


@pytest.fixture(scope="module")
def live(
    tmp_path_factory: pytest.TempPathFactory, external_program: Callable[[str], str]
) -> Iterator[Live]:
    """Send one touching finger at 30 frames a second."""
    ports = {name: free_port() for name in (*FRAMES, "tuio11", "tuio2")}
    formats = {"tuio11": "tuio11", "tuio2": "tuio2"}
    destinations = [
        parse_destination(f"127.0.0.1:{port}/{formats.get(name, 'frames')}")
        for name, port in ports.items()
    ]
    ended = threading.Event()
    with ExitStack() as stack:
        osc = stack.enter_context(closing(OscOutput(destinations)))
        web = stack.enter_context(closing(WebServer(WebSettings(), "desk", "s1")))

        def send() -> None:
            number = 0
            while not ended.wait(PERIOD_S):
                number += 1
                for carrier in (osc, web):
                    carrier.send(frame(number, (FINGER,)))

        thread = threading.Thread(target=send)
        thread.start()
        yield Live(ports, web.url, tmp_path_factory.mktemp("live"), external_program)
        ended.set()
        thread.join()


def pointer_of(arguments: Any) -> dict[str, Any]:
    return dict(zip(NAMES, map(float, arguments), strict=True))


def by_oscdump(live: Live) -> dict[str, Any]:
    for line in live.lines("oscdump", "-L", str(live.ports["oscdump"])):
        if "/halo/1/table/pointer" in line:
            return pointer_of(line.split()[3:])
    raise AssertionError("no pointer")


def by_pure_data(live: Live) -> dict[str, Any]:
    patch = live.folder / "pointer.pd"
    patch.write_text((HERE / "pointer.pd").read_text().replace("PORT", str(live.ports["pd"])))
    for line in live.lines("pd", "-nogui", "-noaudio", "-stderr", "-open", str(patch)):
        if line.startswith("pointer:"):
            return pointer_of(line.split()[1:])
    raise AssertionError("no pointer")


def by_sclang(live: Live) -> dict[str, Any]:
    program = live.folder / "receive.scd"
    program.write_text(
        "thisProcess.addOSCRecvFunc({ |message| message.postcs });"
        f"thisProcess.openUDPPort({live.ports['sclang']});"
    )
    for line in live.lines("sclang", "-D", str(program)):
        if "/halo/1/table/pointer" in line:
            return pointer_of(ast.literal_eval(line)[1:])
    raise AssertionError("no pointer")


def by_python_osc(live: Live) -> dict[str, Any]:
    found: list[Any] = []
    dispatcher = Dispatcher()
    dispatcher.map("/halo/1/table/pointer", lambda _, *arguments: found.append(arguments))
    with BlockingOSCUDPServer(("127.0.0.1", live.ports["python-osc"]), dispatcher) as server:
        server.timeout = PATIENCE_S
        server.handle_request()
    return pointer_of(found[0])


def by_pyliblo(live: Live) -> dict[str, Any]:
    liblo = pytest.importorskip("pyliblo3", reason="pyliblo3 is not installed")
    server = liblo.Server(live.ports["pyliblo3"], proto=liblo.UDP)
    found: list[Any] = []
    server.add_method("/halo/1/table/pointer", None, lambda _, arguments: found.append(arguments))
    until = time.monotonic() + PATIENCE_S
    while not found and time.monotonic() < until:
        server.recv(100)
    server.free()
    return pointer_of(found[0])


def by_tshark(live: Live) -> dict[str, Any]:
    """The floats of a captured datagram; it prints six digits."""
    (raw,) = live.datagrams("tshark", 1)
    udp = struct.pack(">HHHH", 50_000, 4256, 8 + len(raw), 0) + raw
    loopback = socket.inet_aton("127.0.0.1")
    packet = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0) + loopback * 2 + udp
    head = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65_535, 101)
    capture = live.folder / "live.pcap"
    capture.write_bytes(head + struct.pack("<IIII", 0, 0, len(packet), len(packet)) + packet)
    command = ["tshark", "-r", str(capture), "--enable-heuristic", "osc_udp", "-T", "fields"]
    *_, line = live.lines(*command, "-e", "osc.message.float")
    return dict(zip(FLOATS, map(float, line.split(",")), strict=True))


def by_chromium(live: Live) -> dict[str, Any]:
    live.programs("chromium")
    page = """<!doctype html><body><script>
    const socket = new WebSocket(location.search.slice(1), ["halo.1.json"]);
    socket.onmessage = ({ data }) => { socket.close(); report(JSON.parse(data).pointers[0]); };
    </script></body>"""
    view = visit({"index.html": page}, f"index.html?{live.url}")
    words = {"hand": {"right": 2}, "finger": {"index": 1}, "state": {"touch": 1}}
    return {name: words.get(name, {}).get(value, value) for name, value in view.items()}


def by_tuio_client(live: Live) -> dict[str, Any]:
    need_npm(TUIO, "tuio-client")
    text = ""
    for raw in (*live.datagrams("tuio11", 2), *live.datagrams("tuio2", 1)):
        for message in OscBundle(raw):
            arguments = [1 if isinstance(each, tuple) else each for each in message.params]
            text += json.dumps({"address": message.address, "args": arguments}) + "\n"
    done = subprocess.run(
        ["node", "read.js"], cwd=TUIO, input=text + '{"show":true}\n', capture_output=True,
        text=True, timeout=PATIENCE_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    shown = json.loads(done.stdout)
    ((u, v),) = shown["cursors"]
    ((same_u, same_v, pressure, _),) = shown["pointers"]
    assert (u, v) == (same_u, same_v)
    return {"u": u, "v": v, "pressure": pressure}


def by_oscquery(live: Live) -> dict[str, Any]:
    need_npm(OSCQUERY, "oscquery")
    port = re.findall(r":(\d+)/", live.url)[0]
    done = subprocess.run(
        ["node", "read.js", port], cwd=OSCQUERY, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert done.returncode == 0, done.stderr
    nodes = json.loads(done.stdout)["nodes"]
    shared = ("u", "v", "x_mm", "y_mm", "pressure", "force_g", "id")
    return {name: nodes[f"/halo/1/table/slot/0/{name}"]["values"][0] for name in shared}


def need_npm(folder: Path, package: str) -> None:
    if shutil.which("node") is None or not (folder / "node_modules" / package).is_dir():
        if os.environ.get("HALO_CI"):
            pytest.fail(f"{package} is not installed, and .ci/run must install it")
        pytest.skip(f"{package} is not installed: npm install in {folder}")


PROGRAMS: dict[str, tuple[Callable[[Live], dict[str, Any]], int]] = {
    "oscdump": (by_oscdump, 16),
    "Pure Data": (by_pure_data, 16),
    "sclang": (by_sclang, 16),
    "tshark": (by_tshark, 10),
    "python-osc": (by_python_osc, 16),
    "pyliblo3": (by_pyliblo, 16),
    "Chromium": (by_chromium, 16),
    "tuio-client": (by_tuio_client, 3),
    "oscquery": (by_oscquery, 7),
}
"""Program -> how it is asked, and how many values it shows."""


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS)
def test_another_program_shows_the_finger(
    program: str, live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    # sclang starts Qt, which needs no display and, as root, no sandbox.
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    monkeypatch.setenv("QTWEBENGINE_CHROMIUM_FLAGS", "--no-sandbox")
    read, count = PROGRAMS[program]
    shown = read(live)
    assert len(shown) == count
    assert shown == {name: pytest.approx(getattr(FINGER, name), rel=5e-6) for name in shown}
