"""The fleet view with Zenoh as it is: samples and tokens of two nodes of one router."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import pytest
import zenoh

import halo_protocol as wire
from halo_client import ZenohSource
from halo_service.app.fleet import show
from halo_service.app.fleet.node import Node
from halo_service.app.fleet.watch import FleetWatch, sources
from halo_service.app.page.node_calls import NodeCalls
from halo_service.errors import UserError
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput

SCENE = wire.Scene("left", "s1", wire.VERSION, 300.0, 200.0, 2, 0, 0, 30.0, zenoh_version="0.5")


@pytest.fixture
def nodes(free_port: Callable[[], int]) -> Iterator[tuple[str, list[ZenohOutput]]]:
    """A router's endpoint, and two nodes that are connected to it."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = zenoh.Config()
    for key, value in (
        ("mode", "router"),
        ("listen/endpoints", [endpoint]),
        ("scouting/multicast/enabled", False),
    ):
        config.insert_json5(key, json.dumps(value))
    with ExitStack() as stack:
        stack.enter_context(closing(zenoh.open(config)))
        settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,))
        outputs = [ZenohOutput(settings, name, "table") for name in ("left", "right")]
        stack.callback(lambda: [each.close() for each in outputs])
        yield endpoint, outputs


def until(found: Callable[[], list[Any]], wanted: Callable[[list[Any]], bool]) -> list[Any]:
    end_s = time.monotonic() + 20.0
    while not wanted(nodes := found()):
        assert time.monotonic() < end_s, nodes
        time.sleep(0.05)
    return nodes


def test_nodes_are_found_by_their_messages_and_tokens(
    nodes: tuple[str, list[ZenohOutput]],
) -> None:
    endpoint, outputs = nodes
    left, right = outputs
    with closing(FleetWatch(sources(ZenohSettings(), [endpoint]), mdns=False)) as watch:
        until(watch.nodes, lambda found: [each.state for each in found] == ["silent", "silent"])
        left.send(OutgoingReport("table", SCENE))
        found = until(watch.nodes, lambda found: found[0].state == "running")
        assert [(each.node, each.state) for each in found] == [
            ("left", "running"), ("right", "silent"),
        ]  # fmt: skip
        assert found[0].warnings[0].startswith("it has Zenoh 0.5, most others 1.")
        outputs.remove(right)
        right.close()
        until(watch.nodes, lambda found: len(found) == 1)


def test_services_of_one_router_do_not_connect_to_each_other(
    nodes: tuple[str, list[ZenohOutput]],
) -> None:
    """Each would have as many links as there are nodes."""
    infos = [output._session.info for output in nodes[1]]
    until(lambda: infos, lambda infos: all(len(each.routers_zid()) == 1 for each in infos))
    time.sleep(0.3)  # Zenoh's gossip connects peers within some ms
    assert [len(each.peers_zid()) for each in infos] == [0, 0]


def test_the_page_watches_only_while_it_asks(
    nodes: tuple[str, list[ZenohOutput]], monkeypatch: pytest.MonkeyPatch
) -> None:
    endpoint, (left, _) = nodes
    monkeypatch.setattr("halo_service.app.page.node_calls.IDLE_S", 1.0)
    calls = NodeCalls(ZenohSettings(listen=(endpoint,)))
    read = calls.table()["nodes"].run

    def answers() -> list[Any]:
        left.send(OutgoingReport("table", SCENE))  # again: the first comes before the subscription
        return [read({})]

    (answer,) = until(answers, lambda one: any(row[2] == "running" for row in one[0]["rows"]))
    assert answer["warnings"][0].startswith("! left: it has Zenoh 0.5")
    assert len(answer["head"]) == len(answer["rows"][0])
    watched = calls._thread
    assert watched is not None
    watched.join(20.0)
    assert calls._watch is None
    calls.close()


def test_lines_are_printed_when_something_changes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(show, "LINES_S", 0.0)
    gone = Node("left", "table", "s1", state="gone", by="zenoh", first_s=0.0, last_s=0.0)
    here = Node("left", "table", "s1", state="running", by="zenoh", first_s=0.0, last_s=0.0)
    seen = iter([[here], [here], [gone], []])
    stopped = threading.Event()

    class Watched:
        def nodes(self) -> list[Node]:
            nodes = next(seen)
            if not nodes:
                stopped.set()
            return nodes

    show._print_changes(Watched(), stopped)  # type: ignore[arg-type]
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[3] for line in lines] == ["running", "gone"]


@pytest.mark.parametrize(
    ("settings", "connect", "expected"),
    [
        (ZenohSettings(), (), [("tcp/127.0.0.1:7447",)]),
        (ZenohSettings(enabled=False), (), []),
        (ZenohSettings(enabled=False), ("tcp/a:1",), [("tcp/a:1",)]),
        (ZenohSettings(listen=("tcp/0.0.0.0:7",)), (), [("tcp/127.0.0.1:7",)]),
        (ZenohSettings(listen=("tls/[::]:7",)), (), [("tls/[::1]:7",)]),
        (
            ZenohSettings(listen=("tcp/127.0.0.1:7",), connect=("tcp/r:1", "tcp/s:1")), (),
            [("tcp/r:1",), ("tcp/s:1",), ("tcp/127.0.0.1:7",)],
        ),
        (ZenohSettings(config="/x.json5"), (), [()]),
        (ZenohSettings(multicast=True), (), [()]),
    ],
)  # fmt: skip
def test_each_endpoint_has_a_client_of_its_own(
    settings: ZenohSettings, connect: tuple[str, ...], expected: list[tuple[str, ...]]
) -> None:
    assert [each.connect for each in sources(settings, connect)] == expected


def test_an_endpoint_that_cannot_be_is_an_error() -> None:
    with pytest.raises(UserError, match="list: cannot use Zenoh with nonsense"):
        FleetWatch([ZenohSource(("nonsense",), mode="client")], mdns=False)
