"""The control port survives any input."""

from __future__ import annotations

import os
import random
import socket
import time
from collections.abc import Iterator
from contextlib import closing

import pytest
from pythonosc.osc_message_builder import OscMessageBuilder

from halo_service.errors import UserError
from halo_service.outputs.control import QUEUE, ControlMessage, ControlPort
from tests.ports import free_port


@pytest.fixture
def port() -> Iterator[tuple[ControlPort, socket.socket]]:
    number = free_port()
    control = ControlPort("127.0.0.1", number)
    client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    client.connect(("127.0.0.1", number))
    assert control.port == number
    yield control, client
    client.close()
    control.close()


def wait_for(control: ControlPort, count: int) -> list[ControlMessage]:
    got: list[ControlMessage] = []
    until = time.monotonic() + 10.0
    while len(got) < count and time.monotonic() < until:
        got += control.drain()
        time.sleep(0.005)
    return got


def message(address: str, *arguments: object) -> bytes:
    builder = OscMessageBuilder(address)
    for argument in arguments:
        builder.add_arg(argument)
    return bytes(builder.build().dgram)


def test_a_message_is_received(port: tuple[ControlPort, socket.socket]) -> None:
    control, client = port
    client.send(message("/halo/1/sim/finger", 2, 1, 150.0, 100.0, 12.5, 0.0))
    (received,) = wait_for(control, 1)
    assert received.address == "/halo/1/sim/finger"
    assert received.arguments == (2, 1, 150.0, 100.0, 12.5, 0.0)


def test_random_bytes_are_counted_and_the_next_message_is_received(
    port: tuple[ControlPort, socket.socket],
) -> None:
    control, client = port
    chance = random.Random(1)
    random_bytes = [os.urandom(chance.randrange(1, 200)) for _ in range(100)]
    random_bytes += [b"", b"/", b"#bundle\0", b"#bundle\0" + b"\xff" * 12, b"/a\0\0,i\0\0"]
    for datagram in random_bytes:
        client.send(datagram)
        time.sleep(0.001)
    client.send(message("/halo/1/control/background"))
    received = [each for each in wait_for(control, 1) if each.address.startswith("/halo")]
    assert received[-1].address == "/halo/1/control/background"
    assert control.bad >= 90


def test_the_queue_is_bounded(port: tuple[ControlPort, socket.socket]) -> None:
    control, client = port
    for n in range(QUEUE + 50):
        client.send(message("/n", n))
        time.sleep(0.0005)
    time.sleep(0.3)
    assert len(control.drain()) <= QUEUE


def test_a_port_in_use_is_replaced_by_a_free_one(
    port: tuple[ControlPort, socket.socket], caplog: pytest.LogCaptureFixture
) -> None:
    _, client = port
    taken = client.getpeername()[1]
    with closing(ControlPort("127.0.0.1", taken)) as control:
        assert control.port not in (0, taken)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.sendto(message("/halo/1/control/background"), ("127.0.0.1", control.port))
        (received,) = wait_for(control, 1)
    assert received.address == "/halo/1/control/background"
    assert f"port {taken} is in use, so this service uses {control.port}" in caplog.text


@pytest.mark.parametrize("number", [-1, 0, 65_536, 70_000])
def test_an_invalid_port_number_is_one_sentence(number: int) -> None:
    with pytest.raises(UserError, match=f"{number} is not a port; choose one from 1 to 65535"):
        ControlPort("127.0.0.1", number)


@pytest.mark.parametrize("host", ["no.such.host.invalid", "192.0.2.1"])
def test_a_host_of_another_machine_is_not_blamed_on_another_service(host: str) -> None:
    with pytest.raises(UserError, match="host to an address of this machine") as caught:
        ControlPort(host, 4257)
    assert "another halo service" not in str(caught.value)
