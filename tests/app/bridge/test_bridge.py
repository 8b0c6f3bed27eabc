"""A client of the bridge gets what a client of the service gets, through a real Zenoh session."""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

import pytest
import zenoh

import halo_client
import halo_protocol as wire
from halo_client.source import ZenohSource
from halo_client.zenoh_input import ZenohInput
from halo_service.app.bridge.lane import Lane
from halo_service.app.bridge.relay import Relay
from halo_service.app.cli import main
from halo_service.outputs import Carrier
from halo_service.outputs.destination import parse_destination
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame, OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
from tests.app.conftest import HALO, Spawn
from tests.outputs.samples import SIZE_MM, TOUCHING, frame

RECORDED = Path(__file__).parents[2] / "clients" / "recorded" / "drumming.jsonl"
FORMATS = (
    "frames", "frames,timetags=on", "frames,rate=15", "flat", "flat,changes=on", "flat,bundles=off",
    "tuio11", "tuio2",
)  # fmt: skip
FRAMES = 150
WAIT_S = 20.0
MATRIX = (2.0, 0.0, 1.0, 0.0, 2.0, 1.0, 0.0, 0.0, 1.0)


def scene(node: str = "desk", session: str = "s1") -> OutgoingReport:
    message = wire.Scene(node, session, wire.VERSION, *SIZE_MM, 2, 1, 0, 30.0)
    return OutgoingReport("table", message)


def homography() -> OutgoingReport:
    return OutgoingReport("table", wire.Homography("desk", "s1", 1, 1280, 800, MATRIX))


def recorded() -> Iterator[OutgoingFrame]:
    """The recorded stream, each event in three frames, as the service sends it."""
    past: list[halo_client.TouchFrame] = []
    for each in halo_client.frames(halo_client.FileSource(RECORDED, paced=False)):
        past = [*past[-2:], each]
        header = wire.Frame(
            "desk", "s1", each.frame, *divmod(each.time_us, 10**6), len(each.pointers),
            each.session_ms,
        )  # fmt: skip
        late = [(old, (each.time_us - old.time_us) / 1000.0) for old in past]
        downs = tuple(replace(e, ago_ms=e.ago_ms + ms) for old, ms in late for e in old.downs)
        ups = tuple(replace(e, ago_ms=e.ago_ms + ms) for old, ms in late for e in old.ups)
        yield OutgoingFrame("table", SIZE_MM, header, each.pointers, downs, ups)


class Port:
    """A UDP port of a local client."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self.place = f"127.0.0.1:{self._socket.getsockname()[1]}"
        self.got: list[bytes] = []
        self.close = self._socket.close

    def drain(self) -> list[bytes]:
        try:
            while True:
                self.got.append(self._socket.recv(65_536))
        except BlockingIOError:
            return self.got

    def messages(self) -> list[wire.Message]:
        return [message for each in self.drain() for _, message in wire.decode(each)]


def until(condition: Callable[[], object], wait_s: float = WAIT_S, every_s: float = 0.0005) -> None:
    end_s = time.monotonic() + wait_s
    while not condition():
        assert time.monotonic() < end_s, "it did not happen in time"
        time.sleep(every_s)


def knows_all(late: halo_client.Receiver) -> bool:
    """Whether it has scene and homography, after one more datagram."""
    late.poll(0.05)
    return bool(late.services.scenes and late.services.homographies)


def opened_router(endpoint: str, *, adminspace: bool = False) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("adminspace/enabled", json.dumps(adminspace))
    config.insert_json5("listen/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def endpoint(free_port: Callable[[], int]) -> str:
    return f"tcp/127.0.0.1:{free_port()}"


def lane_to(endpoint: str, places: list[str], stack: ExitStack) -> tuple[Lane, Relay]:
    follow = halo_client.Follow(node="desk")
    source = ZenohInput(ZenohSource((endpoint,), mode="client", follow=follow))
    relay = Relay()
    lane = Lane(source, follow, relay, [parse_destination(each) for each in places], ())
    stack.callback(lane.close)
    return lane, relay


def test_in_every_format_a_client_gets_the_bytes_of_the_service(
    endpoint: str, stack: ExitStack
) -> None:
    ports = {name: (Port(), Port()) for name in FORMATS}
    for each in (port for pair in ports.values() for port in pair):
        stack.callback(each.close)
    direct = [parse_destination(f"{pair[0].place}/{name}") for name, pair in ports.items()]
    bridged = [f"{pair[1].place}/{name}" for name, pair in ports.items()]
    service: list[Carrier] = [
        stack.enter_context(closing(OscOutput(direct))),
        stack.enter_context(
            closing(ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table"))
        ),
    ]
    _, relay = lane_to(endpoint, bridged, stack)

    def send(outgoing: Outgoing) -> None:
        for carrier in service:
            carrier.send(outgoing)

    def connected() -> bool:
        send(scene())
        return bool(ports["frames"][1].drain())

    until(connected, every_s=0.02)
    bridged_ports = [pair[1] for name, pair in ports.items() if name.startswith("frames")]
    send(homography())  # the last report before the start
    for port in bridged_ports:
        until(lambda port=port: any(isinstance(e, wire.Homography) for e in port.messages()))  # type: ignore[misc]
    for port in (port for pair in ports.values() for port in pair):
        port.drain()
        port.got.clear()
    frames = list(recorded())[:FRAMES]
    assert sum(len(each.downs) for each in frames) > 5
    send(scene())
    send(homography())
    for port in bridged_ports:  # Zenoh lets frames overtake reports
        until(lambda port=port: len(port.drain()) >= 2)  # type: ignore[misc]
    for number, each in enumerate(frames, 1):
        send(each)
        until(lambda number=number: relay.frames >= number)  # type: ignore[misc]
        for port in (port for pair in ports.values() for port in pair):
            port.drain()
    for name, (one, other) in ports.items():
        until(lambda one=one, other=other: len(other.drain()) >= len(one.drain()))  # type: ignore[misc]
        assert len(one.got) > FRAMES / 4, name
        assert other.got == one.got, name
    assert relay.missed == 0


def test_a_cut_link_ends_the_touch_and_a_restarted_router_brings_the_stream_back(
    endpoint: str, stack: ExitStack
) -> None:
    port = Port()
    stack.callback(port.close)
    router = opened_router(endpoint)
    settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,))
    service = stack.enter_context(closing(ZenohOutput(settings, "desk", "table")))
    lane, relay = lane_to(endpoint, [port.place], stack)
    number = 0

    def send() -> None:
        nonlocal number
        number += 1
        service.send(frame(number, (TOUCHING,)))

    def arrives() -> bool:
        send()
        return relay.frames > before

    before = 0
    until(arrives, every_s=0.02)
    router.close()
    cut_at = number

    def is_empty() -> bool:
        headers = [each for each in port.messages() if isinstance(each, wire.Frame)]
        return bool(headers) and headers[-1].count == 0

    until(is_empty, 6.0, 0.05)
    assert any(isinstance(each, wire.Up) for each in port.messages())
    number += 200  # what the service sent while the link was cut
    stack.callback(opened_router(endpoint).close)
    before = relay.frames
    until(arrives, every_s=0.02)
    until(lambda: not is_empty())
    assert relay.missed >= 200
    assert f"{relay.missed} frames missed" in lane.status
    assert cut_at < number


def test_the_touch_of_a_killed_service_ends_before_3_s_of_silence(
    endpoint: str, stack: ExitStack
) -> None:
    port = Port()
    stack.callback(port.close)
    stack.callback(opened_router(endpoint).close)
    settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,))
    service = ZenohOutput(settings, "desk", "table")
    _, relay = lane_to(endpoint, [port.place], stack)
    numbers = count(1)
    until(lambda: service.send(frame(next(numbers), (TOUCHING,))) or relay.frames, every_s=0.02)
    service._session.close()  # as a killed process: without a last frame
    until(lambda: any(isinstance(each, wire.Up) for each in port.messages()), 2.5, 0.01)


def test_the_command_serves_late_clients_and_says_at_its_end_what_it_lost(
    endpoint: str, spawn: Spawn, free_port: Callable[[], int], stack: ExitStack, tmp_path: Path
) -> None:
    port = Port()
    stack.callback(port.close)
    service = stack.enter_context(
        closing(ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table"))
    )
    (config := tmp_path / "halo.toml").write_text(f"[web]\nport = {free_port()}\n")
    bridge = spawn(
        HALO, "bridge", "--connect", endpoint, "--node", "desk", "--osc", port.place,
        "--config", config, "--control-port", str(free_port()),
    )  # fmt: skip
    number = 0

    def arrives() -> bool:
        nonlocal number
        number += 1
        for each in (scene(), homography(), frame(number, (TOUCHING,))):
            service.send(each)
        return any(isinstance(each, wire.Pointer) for each in port.messages())

    until(arrives, every_s=0.05)
    service.send(frame(number + 4, (TOUCHING,)))
    assert bridge.stderr is not None
    lines: list[str] = []
    while not (found := re.search(r"(ws://\S+?);.*control port (\d+)", "".join(lines))):
        lines.append(bridge.stderr.readline())
    for url in (found[1], f"osc://?hello=127.0.0.1:{found[2]}"):
        with halo_client.connect(url) as late:  # the service sends nothing any more
            until(partial(knows_all, late))
            assert ("desk", "table") in late.services.scenes
    bridge.send_signal(signal.SIGTERM)
    assert bridge.wait(WAIT_S) == 0
    said = bridge.stderr.read()
    assert re.search(r"desk/table: \d+ frames arrived, 3 frames missed", said), said
    headers = [each for each in port.messages() if isinstance(each, wire.Frame)]
    assert headers[-1].count == 0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--node", "Desk"], "write --node NAME or NAME/SURFACE"),
        (["--node", "a", "--node", "a"], "name each --node once"),
        (["--node", "a" * 30, "--node", "b"], "at most 32 characters"),
        (["--connect", "nonsense"], "write endpoints as tcp/HOST:PORT"),
        (["--osc", "nowhere"], "is not a destination"),
    ],
)
def test_wrong_options_are_one_sentence(
    options: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bridge", *options]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert says in said[0]


def test_it_needs_no_camera_no_hand_tracker_and_no_scipy() -> None:
    script = (
        "import sys; from halo_service.app.bridge import run; from halo_service.web import server;"
        "from halo_service.settings import load; load(None); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    imported = set(done.stdout.split())
    assert "halo_service.app.bridge.run" in imported, done.stderr
    rooms = ("sources", "hand_tracking", "virtual", "evaluation")
    absent = {"mediapipe", "scipy", "pyk4a", "sklearn", *(f"halo_service.{room}" for room in rooms)}
    assert not absent & imported
