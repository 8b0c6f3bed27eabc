"""Hello, welcome, lease, goodbye: the outcomes as a table, and what forgers get."""

from __future__ import annotations

import itertools
import random

import pytest

import halo_protocol as wire
from halo_protocol.handshake import EXPIRED, GOODBYE, HELLO, LEASE, LEAST_HELLO, WELCOME
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage
from halo_service.outputs.leases import LEASE_S, MOST_LEASES, Leases

HERE = ("127.0.0.1", 5000)
NETWORKS = ("127.0.0.0/8", "::1/128")


def leases(networks: tuple[str, ...] = NETWORKS) -> Leases:
    numbers = itertools.count()
    return Leases("desk", "s1", networks, lambda: f"t{next(numbers)}")


def hello(
    version: str = "1.0.0", stream: str = "frames", port: int = 0, sender: tuple[str, int] = HERE
) -> ControlMessage:
    return ControlMessage(HELLO, (version, stream, port, "padding"), sender, LEAST_HELLO)


def say(address: str, token: str, sender: tuple[str, int] = HERE) -> ControlMessage:
    return ControlMessage(address, (token,), sender, 44)


def welcome(service: Leases, message: ControlMessage) -> tuple[wire.Argument, ...]:
    (reply,) = service.handle(message, 0.0)
    assert reply.to == message.sender
    assert len(reply.datagram) <= message.size
    ((address, arguments),) = wire.parse_osc(reply.datagram)
    assert address == WELCOME
    return arguments


@pytest.mark.parametrize(
    ("version", "stream", "outcome", "reason"),
    [
        ("1.0.0", "frames", "accepted", ""),
        ("1.0.9", "flat,rate=30", "accepted", ""),
        ("1.0.0", "tuio2", "accepted", ""),
        ("1.1.0", "frames", "refused", f"this service speaks {wire.VERSION}"),
        ("2.0.0", "frames", "refused", f"this service speaks {wire.VERSION}"),
        ("0.9.0", "frames", "refused", f"this service speaks {wire.VERSION}"),
        ("one", "frames", "refused", "version must be major.minor.patch"),
        ("1.0.0", "midi", "refused", "unknown format 'midi'"),
        ("1.0.0", "frames,rate=0", "refused", "rate must be"),
        ("1.0.0", "ä" * 100, "refused", "unknown format"),
    ],
)
def test_the_outcome_of_a_hello(version: str, stream: str, outcome: str, reason: str) -> None:
    service = leases()
    arguments = welcome(service, hello(version, stream))
    node, session, spoken, said, token, why, lease_ms = arguments
    assert (node, session, spoken, said, lease_ms) == ("desk", "s1", wire.VERSION, outcome, 10_000)
    assert reason in str(why)
    assert bool(token) == (outcome == "accepted")
    assert service.destinations == [], "nothing is streamed before the lease"


def test_a_client_with_an_older_minor_is_accepted_with_a_warning(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(wire, "VERSION", "1.3.0")
    assert welcome(leases(), hello("1.2.0"))[3] == "warned"


def test_a_lease_streams_until_it_ends() -> None:
    service = leases()
    token = str(welcome(service, hello(stream="flat", port=7000))[4])
    assert service.handle(say(LEASE, token), 0.0) == []
    (destination,) = service.destinations
    assert (destination.host, destination.port, destination.stream.format) == (
        "127.0.0.1", 7000, "flat",
    )  # fmt: skip
    service.expire(LEASE_S - 0.1)
    assert service.handle(say(LEASE, token), LEASE_S - 0.1) == []
    service.expire(2 * LEASE_S - 0.2)
    assert len(service.destinations) == 1
    service.expire(2 * LEASE_S)
    assert service.destinations == []


def test_after_a_lease_ended_the_client_is_asked_to_say_hello_again() -> None:
    service = leases()
    message = say(LEASE, "t99")
    (reply,) = service.handle(message, 0.0)
    assert wire.parse_osc(reply.datagram) == [(EXPIRED, ("t99",))]
    assert len(reply.datagram) <= message.size


def test_goodbye_ends_the_stream_at_once() -> None:
    service = leases()
    token = str(welcome(service, hello())[4])
    service.handle(say(LEASE, token), 0.0)
    service.handle(say(GOODBYE, token, ("127.0.0.2", 1)), 0.0)
    assert len(service.destinations) == 1, "another host cannot end it"
    service.handle(say(GOODBYE, token), 0.0)
    assert service.destinations == []


def test_many_clients_each_have_their_own_stream() -> None:
    service = leases()
    for n, stream in enumerate(["frames", "flat", "tuio11", "frames,rate=10"]):
        token = str(welcome(service, hello(stream=stream, sender=("127.0.0.1", 6000 + n)))[4])
        service.handle(say(LEASE, token), 0.0)
    assert [each.port for each in service.destinations] == [6000, 6001, 6002, 6003]
    assert len({each.stream for each in service.destinations}) == 4


@pytest.mark.parametrize("host", ["192.0.2.7", "10.0.0.1", "::2", "not an address", ""])
def test_a_host_outside_the_networks_gets_nothing(host: str) -> None:
    service = leases()
    assert service.handle(hello(sender=(host, 1)), 0.0) == []
    assert service.handle(say(LEASE, "t0", (host, 1)), 0.0) == []
    assert service.destinations == []
    assert service.refused == 2


def test_a_network_can_be_opened() -> None:
    assert welcome(leases(("192.0.2.0/24",)), hello(sender=("192.0.2.7", 1)))[3] == "accepted"


def test_a_forged_sender_gets_no_stream() -> None:
    service = leases(("192.0.2.0/24",))
    token = str(welcome(service, hello(sender=("192.0.2.7", 9)))[4])
    # The forger does not see the token that went to the victim; a token of its own does not help.
    own = str(welcome(service, hello(sender=("192.0.2.66", 9)))[4])
    service.handle(say(LEASE, own, ("192.0.2.7", 9)), 0.0)
    service.handle(say(LEASE, "t77", ("192.0.2.7", 9)), 0.0)
    assert service.destinations == []
    service.handle(say(LEASE, token, ("192.0.2.7", 9)), 0.0)
    assert [each.host for each in service.destinations] == ["192.0.2.7"]


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("1.0.0",),
        ("1.0.0", "frames"),
        (1, "frames", 0),
        ("1.0.0", None, 0),
        ("1.0.0", "frames", -1),
        ("1.0.0", "frames", 65_536),
        ("1.0.0", "frames", "5000"),
    ],
)
def test_a_malformed_hello_gets_no_answer(arguments: tuple[wire.Argument, ...]) -> None:
    service = leases()
    assert service.handle(ControlMessage(HELLO, arguments, HERE, 300), 0.0) == []
    assert service.refused == 1


def test_a_short_hello_gets_no_answer_so_no_answer_is_larger_than_its_question() -> None:
    message = ControlMessage(HELLO, ("1.0.0", "frames", 0), HERE, LEAST_HELLO - 4)
    assert leases().handle(message, 0.0) == []


def test_no_number_of_clients_fills_the_memory() -> None:
    service = leases()
    for n in range(3000):
        token = str(welcome(service, hello(sender=("127.0.0.1", 1 + n)))[4])
        if n % 2:
            service.handle(say(LEASE, token, ("127.0.0.1", 1 + n)), 0.0)
    assert len(service.destinations) == MOST_LEASES
    assert len(service._welcomed) <= 256


def test_random_messages_raise_nothing_and_stream_nothing() -> None:
    chance = random.Random(3)
    service = leases()
    values: list[wire.Argument] = [
        "1.0.0",
        "frames",
        0,
        -1,
        1.5,
        None,
        b"x",
        "t0",
        "",
        True,
        "x" * 999,
    ]
    for _ in range(20_000):
        arguments = tuple(chance.choices(values, k=chance.randrange(6)))
        address = chance.choice([HELLO, GOODBYE, LEASE])
        size = chance.choice([0, 44, LEAST_HELLO])
        for reply in service.handle(ControlMessage(address, arguments, HERE, size), 0.0):
            assert len(reply.datagram) <= max(size, 1100)
    assert len(service.destinations) <= 1, "t0 was welcomed and may be leased"


def test_a_bad_network_is_one_sentence() -> None:
    with pytest.raises(UserError, match=r"'home' is not a network; write one such as 192\.168"):
        Leases("desk", "s1", ["home"])
