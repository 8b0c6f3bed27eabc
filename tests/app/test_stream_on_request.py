"""A client without an entry in any settings asks for the stream, over real sockets."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from threading import Event

import pytest
from pythonosc.osc_message_builder import OscMessageBuilder

import halo_protocol as wire
from halo_protocol.osc import IMMEDIATELY, bundle
from halo_service.app.service.control_handler import ControlHandler
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.outputs.control import ControlPort
from halo_service.outputs.leases import Leases
from halo_service.outputs.networks import Networks
from halo_service.outputs.osc import OscOutput
from halo_service.sensing import SensingSettings, start
from tests.outputs.samples import TOUCHING, frame

pytestmark = pytest.mark.slow


@dataclass
class Service:
    control: ControlPort
    handler: ControlHandler
    osc: OscOutput
    number: int = 0

    def turn(self) -> None:
        """One round of the live loop."""
        self.handler.handle(start(None, SensingSettings()), None)
        self.osc.send(frame(self.number, (TOUCHING,)))
        self.number += 1


@pytest.fixture
def service(camera) -> Iterator[Service]:
    control = ControlPort("127.0.0.1", 4257)
    with (
        closing(control),
        closing(OscOutput([])) as osc,
        closing(ProfileReloader(None, camera, None)) as reloader,
    ):
        leases = Leases("desk", "s1", ("127.0.0.0/8",))
        yield Service(control, ControlHandler(control, reloader, leases, osc, Event()), osc)


@pytest.fixture
def client() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        client.settimeout(0.05)
        yield client


def message(address: str, *arguments: str | int) -> bytes:
    builder = OscMessageBuilder(f"/halo/1/control/{address}")
    for argument in arguments:
        builder.add_arg(argument)
    return bytes(builder.build().dgram)


def next_message(service: Service, client: socket.socket) -> tuple[str, tuple[wire.Argument, ...]]:
    until = time.monotonic() + 10.0
    while time.monotonic() < until:
        service.turn()
        try:
            return wire.parse_osc(client.recv(65_536))[0]
        except TimeoutError:
            continue
    pytest.fail("no answer")


def test_hello_lease_goodbye(service: Service, client: socket.socket) -> None:
    to = ("127.0.0.1", service.control.port)
    client.sendto(message("hello", "1.0.0", "frames", 0, " " * 256), to)
    address, arguments = next_message(service, client)
    assert address == "/halo/1/control/welcome"
    assert arguments[:4] == ("desk", "s1", "1.0.0", "accepted")
    client.sendto(message("lease", str(arguments[4])), to)
    address, header = next_message(service, client)
    assert address == "/halo/1/table/frame"
    assert header[:2] == ("desk", "s1")
    client.sendto(message("goodbye", str(arguments[4])), to)
    until = time.monotonic() + 10.0
    while service.osc._leased and time.monotonic() < until:
        service.turn()
        time.sleep(0.01)
    assert service.osc._leased == {}
    assert service.osc._channels == {}


def test_nothing_is_streamed_after_hello_alone(service: Service, client: socket.socket) -> None:
    to = ("127.0.0.1", service.control.port)
    client.sendto(message("hello", "1.0.0", "frames", 0, " " * 256), to)
    assert next_message(service, client)[0] == "/halo/1/control/welcome"
    for _ in range(10):
        service.turn()
    with pytest.raises(TimeoutError):
        client.recv(65_536)


def bundled(*messages: bytes) -> bytes:
    return bundle(IMMEDIATELY, *messages)


SHORT_HELLO = message("hello", "1.0.0", "frames", 0)
ATTACKS = {
    "hello": message("hello", "1.0.0", "frames", 0, " " * 256),
    "refused hello": message("hello", "1.0.0", "midi" * 50, 0, " " * 256),
    "short hello": SHORT_HELLO,
    "bundle of short hellos": bundled(*[SHORT_HELLO] * 20),
    "bundle of short questions": bundled(*[message("status")] * 20),
    "question": message("status", " " * 256),
    "lease": message("lease", "t0123456789abcdef"),
    "bundle of leases": bundled(*[message("lease", "")] * 20),
    "malformed": message("hello", "1.0.0")[:-4],
}


@pytest.mark.parametrize("attack", ATTACKS.values(), ids=ATTACKS)
@pytest.mark.parametrize(("networks", "allowed"), [("127.0.0.0/8", True), ("127.0.0.2", False)])
def test_a_forged_sender_never_gets_more_bytes_than_were_sent(
    service: Service, client: socket.socket, attack: bytes, networks: str, allowed: bool
) -> None:
    """The client is the victim: it never sends a token back."""
    service.handler._leases.networks = Networks((networks,))
    received = []
    client.sendto(attack, ("127.0.0.1", service.control.port))
    for _ in range(3):
        service.turn()
        with suppress(TimeoutError):
            while True:
                received.append(client.recv(65_536))
    assert sum(map(len, received)) <= len(attack)
    assert allowed or not received
    assert not any(raw.startswith((b"#bundle", b"/halo/1/table")) for raw in received)
    assert service.osc._leased == {}


def test_a_question_is_answered_alone_and_in_a_bundle(
    service: Service, client: socket.socket
) -> None:
    """The attacks above would be answered if they were large enough."""
    for question in (ATTACKS["question"], bundled(ATTACKS["question"])):
        client.sendto(question, ("127.0.0.1", service.control.port))
        assert next_message(service, client)[0] == "/halo/1/control/status"
