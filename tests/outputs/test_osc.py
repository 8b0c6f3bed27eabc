"""Destinations of all kinds receive, each in its own form, and a bad one delays no other."""

from __future__ import annotations

import logging
import socket
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

import halo_protocol as wire
from halo_service.outputs import udp_sender
from halo_service.outputs.destination import parse_destination
from halo_service.outputs.name_resolver import NameResolver
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.outputs.udp_sender import UdpSender
from tests.outputs.samples import TOUCHING, fingers, frame

SCENE = OutgoingReport("table", wire.Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0))


@pytest.fixture
def listen() -> Iterator[Callable[..., socket.socket]]:
    """`listen(host, port)` -> a socket that receives there."""
    sockets: list[socket.socket] = []

    def opened(host: str = "127.0.0.1", port: int = 0) -> socket.socket:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        receiver = socket.socket(family, socket.SOCK_DGRAM)
        sockets.append(receiver)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.bind((host, port))
        receiver.settimeout(5.0)
        return receiver

    yield opened
    for each in sockets:
        each.close()


def port_of(receiver: socket.socket) -> int:
    return int(receiver.getsockname()[1])


def output(*texts: str) -> closing[OscOutput]:
    return closing(OscOutput([parse_destination(text) for text in texts]))


def received(receiver: socket.socket) -> list[bytes]:
    receiver.settimeout(0.3)
    got = []
    try:
        while True:
            got.append(receiver.recv(65_536))
    except TimeoutError:
        return got


def test_each_destination_has_its_own_form(listen: Callable[..., socket.socket]) -> None:
    receivers = {name: listen() for name in ("frames", "flat", "slow", "wall", "bare", "tagged")}
    at = {name: f"127.0.0.1:{port_of(each)}" for name, each in receivers.items()}
    with output(
        at["frames"], f"{at['flat']}/flat", f"{at['slow']},rate=10", f"{at['wall']},surface=wall",
        f"{at['bare']},bundles=off", f"{at['tagged']},timetags=on",
    ) as osc:  # fmt: skip
        for n in range(30):
            osc.send(frame(n, (TOUCHING,)))
        osc.send(SCENE)
    got = {name: received(each) for name, each in receivers.items()}
    assert len(got["frames"]) == 31
    assert got["frames"][0][8:16] == bytes(7) + b"\x01"
    assert sum(b"/slot/0/u\0" in each for each in got["flat"]) == 30
    assert not any(b"/pointer" in each for each in got["flat"])
    assert len(got["slow"]) == pytest.approx(11, abs=1)
    assert got["wall"] == []
    assert [each.split(b"\0")[0].rpartition(b"/")[2] for each in got["bare"][:3]] == [
        b"frame", b"pointer", b"alive",
    ]  # fmt: skip
    assert struct.unpack(">I", got["tagged"][0][8:12]) == (1_700_000_000 + 2_208_988_800,)


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_localhost_is_ipv4_first_and_ipv6_too(
    host: str, listen: Callable[..., socket.socket]
) -> None:
    receiver = listen(host)
    with output(f"localhost:{port_of(receiver)}") as osc:
        for n in range(10):
            osc.send(frame(n))
            time.sleep(0.01)
    assert len(received(receiver)) >= 8


def test_a_receiver_that_starts_later_gets_frames(listen: Callable[..., socket.socket]) -> None:
    first = listen()
    port = port_of(first)
    first.close()
    with output(f"127.0.0.1:{port}") as osc:
        for n in range(5):
            osc.send(frame(n))
            time.sleep(0.01)
        receiver = listen("127.0.0.1", port)
        for n in range(5, 10):
            osc.send(frame(n))
            time.sleep(0.01)
    assert len(received(receiver)) >= 4


def test_a_broadcast_address_is_sent_to(listen: Callable[..., socket.socket]) -> None:
    receiver = listen("0.0.0.0")
    with output(f"127.255.255.255:{port_of(receiver)}") as osc:
        osc.send(frame(1))
    assert received(receiver) == frame(1).datagrams


@pytest.mark.parametrize("interface", ["lo", "127.0.0.1"])
def test_a_multicast_group_is_sent_to(interface: str, listen: Callable[..., socket.socket]) -> None:
    receiver = listen("0.0.0.0")
    group = socket.inet_aton("239.255.42.56") + socket.inet_aton("127.0.0.1")
    receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    with output(f"239.255.42.56:{port_of(receiver)},ttl=0,interface={interface}") as osc:
        osc.send(frame(1))
    assert received(receiver) == frame(1).datagrams


def test_the_multicast_options_reach_the_socket() -> None:
    sender = udp_sender._opened(
        parse_destination("239.255.42.56:9,ttl=7,interface=lo"), (socket.AF_INET, "239.255.42.56")
    )
    with sender:
        assert sender.getsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL) == 7


def test_an_unknown_name_is_logged_once_and_delays_no_other(
    listen: Callable[..., socket.socket], caplog: pytest.LogCaptureFixture
) -> None:
    receiver = listen()
    with (
        caplog.at_level(logging.WARNING),
        output("no.such.host.invalid:9", f"127.0.0.1:{port_of(receiver)}") as osc,
    ):
        started_s = time.monotonic()
        for n in range(100):
            osc.send(frame(n))
        assert time.monotonic() - started_s < 1.0
        until = time.monotonic() + 20.0
        while not caplog.records and time.monotonic() < until:
            time.sleep(0.05)
    assert len(received(receiver)) == 100
    (record,) = caplog.records
    assert "'no.such.host.invalid' has no address yet" in record.getMessage()
    assert "check its name in --osc" in record.getMessage()


def test_a_name_that_appears_and_then_moves_is_followed(
    listen: Callable[..., socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = listen("127.0.0.1"), listen("127.0.0.2", 0)
    book: dict[str, str] = {}

    def answer(host: str, *_: object, **__: object) -> list[object]:
        # The system's name service, which a test cannot change.
        if host not in book:
            raise socket.gaierror(-2, "Name or service not known")
        return [(socket.AF_INET, socket.SOCK_DGRAM, 17, "", (book[host], 0))]

    monkeypatch.setattr(udp_sender.socket, "getaddrinfo", answer)
    port = port_of(first)
    moved = listen("127.0.0.2", port)
    second.close()
    sender = UdpSender(parse_destination(f"synth.local:{port}"))
    with closing(sender), closing(NameResolver([sender], retry_s=0.02, again_s=0.05)):
        sender.send([b"lost"])
        book["synth.local"] = "127.0.0.1"
        assert eventually(lambda: sender.send([b"one"]), first)
        book["synth.local"] = "127.0.0.2"
        assert eventually(lambda: sender.send([b"two"]), moved)


def eventually(action: Callable[[], None], receiver: socket.socket) -> bytes:
    receiver.settimeout(0.05)
    for _ in range(100):
        action()
        try:
            return receiver.recv(100)
        except TimeoutError:
            continue
    return b""


def test_ten_fingers_stay_below_the_largest_bundle(
    listen: Callable[..., socket.socket],
) -> None:
    formats = ("frames", "flat", "tuio11", "tuio2")
    receivers = {name: listen() for name in formats}
    with output(*(f"127.0.0.1:{port_of(each)}/{n}" for n, each in receivers.items())) as osc:
        osc.send(frame(1, fingers(10)))
    for name, receiver in receivers.items():
        got = received(receiver)
        assert got, name
        assert max(map(len, got)) <= 1232, name


def test_leased_destinations_come_and_go(listen: Callable[..., socket.socket]) -> None:
    fixed, first, second = listen(), listen(), listen()
    places = [parse_destination(f"127.0.0.1:{port_of(each)}/flat") for each in (first, second)]
    with output(f"127.0.0.1:{port_of(fixed)}") as osc:
        for n, leased in enumerate([places[:1], places, places[1:], []]):
            osc.set_leased(leased)
            osc.send(frame(n))
    counts = [sum(b"/count" in raw for raw in received(each)) for each in (first, second)]
    assert counts == [2, 2]
    assert len(received(fixed)) == 4
