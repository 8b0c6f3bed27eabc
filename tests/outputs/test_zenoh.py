"""The same bytes as Zenoh samples, for those who were there and those who come late."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator

import pytest
import zenoh

from halo_service.errors import UserError
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput

WAIT_S = 20.0


@pytest.fixture
def endpoint(free_port: Callable[[], int]) -> str:
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture
def output(endpoint: str) -> Iterator[ZenohOutput]:
    carrier = ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table")
    yield carrier
    carrier.close()


@pytest.fixture
def client(endpoint: str, output: ZenohOutput) -> Iterator[zenoh.Session]:
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    yield session
    session.close()


def test_each_datagram_is_a_sample_under_its_key(
    output: ZenohOutput, client: zenoh.Session
) -> None:
    got: list[tuple[str, bytes]] = []
    arrived = threading.Event()

    def keep(sample: zenoh.Sample) -> None:
        got.append((str(sample.key_expr), bytes(sample.payload)))
        if len(got) >= 2:
            arrived.set()

    subscriber = client.declare_subscriber("halo/1/**", keep)
    for _ in range(100):  # until the subscription has reached the peer
        output.send("frame", [b"part one", b"part two"])
        if arrived.wait(0.1):
            break
    subscriber.undeclare()
    assert got[:2] == [
        ("halo/1/desk/table/frame", b"part one"),
        ("halo/1/desk/table/frame", b"part two"),
    ]


def test_a_late_joiner_asks_for_what_is_retained(
    output: ZenohOutput, client: zenoh.Session
) -> None:
    output.send("scene", [b"old"])
    output.send("scene", [b"new"])
    replies = list(client.get("halo/1/*/*/scene", timeout=WAIT_S))
    assert [bytes(reply.ok.payload) for reply in replies if reply.ok] == [b"new"]


def test_frames_are_not_retained(output: ZenohOutput, client: zenoh.Session) -> None:
    output.send("frame", [b"a frame"])
    assert list(client.get("halo/1/*/*/frame", timeout=2.0)) == []


def test_a_token_says_that_the_node_is_there(output: ZenohOutput, client: zenoh.Session) -> None:
    tokens = list(client.liveliness().get("halo/1/*/alive", timeout=WAIT_S))
    assert [str(token.ok.key_expr) for token in tokens if token.ok] == ["halo/1/desk/alive"]


def test_an_endpoint_in_use_is_one_sentence(endpoint: str, output: ZenohOutput) -> None:
    with pytest.raises(UserError, match="another service or router may have the port"):
        ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table")
