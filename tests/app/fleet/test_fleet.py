"""What the fleet view shows and warns of, from messages with the times at which they arrive."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import halo_protocol as wire
from halo_service.app.discovery import Service
from halo_service.app.fleet.fleet import GONE_S, MOST_NODES, Fleet
from halo_service.app.fleet.node import Node, Versions
from halo_service.app.fleet.view import cells, line_of, value_of, warnings_of

HERE = Versions("1.0.0", "0.1.0", "1.9.0")
UNIX_S = 1_700_000_000
SCENE = wire.Scene(
    "left", "s1", "1.0.0", 300.0, 200.0, 2, 1, 0, 30.0, 4257, 0, UNIX_S - 3 * 86_400, "0.1.0",
    "1.9.0",
)  # fmt: skip
HEALTH = wire.Health("left", "s1", 29.75, 3.5, 0, 0, 3, 1, time_s=UNIX_S, time_frac_us=250_000)
ANNOUNCED = Service("left", "table", "s1", 30.0, "mdns", "10.0.0.5:4257")


def sent(fleet: Fleet, message: wire.Scene | wire.Health, now_s: float, delay_ms: int = 0) -> None:
    """Let a message arrive; the clocks of both machines agree."""
    kind = type(message).__name__.lower()
    key = wire.zenoh_key(message.node, "table", kind)
    unix_us = UNIX_S * 1_000_000 + 250_000 + delay_ms * 1000
    fleet.sample(key, wire.encode("table", message), unix_us, now_s)


def running(fleet: Fleet, *scenes: wire.Scene, until_s: float = 2.0) -> list[Node]:
    """Let scenes arrive twice a second; return what is shown then."""
    for half in range(int(2 * until_s) + 1):
        for scene in scenes:
            sent(fleet, scene, half / 2)
    return fleet.nodes(until_s, UNIX_S)


def test_a_node_is_shown_with_all_that_it_reports() -> None:
    fleet = Fleet(HERE)
    sent(fleet, SCENE, 0.0)
    for delay_ms in (40, 2, 9):
        sent(fleet, HEALTH, 1.0, delay_ms)
    fleet.announced([ANNOUNCED], 1.0)
    (node,) = fleet.nodes(1.5, UNIX_S)
    assert cells(node) == (
        "left", "table", "running", "29.8/30", "3.5", "-2.0", "0.1.0", "1.9.0", "1.0.0",
        "3 days", "both",
    )  # fmt: skip
    assert node.warnings == ()
    assert line_of(node).startswith("left  table  running  29.8/30 Hz  latency 3.5 ms  clock")
    value = json.loads(json.dumps(value_of(node)))
    assert (value["zenoh_version"], value["address"]) == ("1.9.0", "10.0.0.5:4257")


OTHERS = [
    ({"zenoh_version": "1.7.2"}, "it has Zenoh 1.7.2, most others 1.9.0"),
    ({"version": "1.1.0"}, "it speaks protocol 1.1.0, most others 1.0"),
    ({"version": "1.0.7"}, None),
    ({"service_version": "0.2.0"}, None),
    ({"zenoh_version": ""}, None),
    ({"collision": 1}, "it reports another service with its name; rename one with --node"),
]


@pytest.mark.parametrize(("changes", "warning"), OTHERS)
def test_one_of_three_nodes_that_differs_is_warned_of(
    changes: dict[str, object], warning: str | None
) -> None:
    odd = replace(SCENE, node="odd", **changes)  # type: ignore[arg-type]
    nodes = running(Fleet(HERE), SCENE, replace(SCENE, node="right"), odd)
    assert warnings_of(nodes) == ([] if warning is None else [f"! odd: {warning}"])
    assert cells(nodes[1])[0] == ("odd" if warning is None else "! odd")


def test_the_version_of_most_nodes_counts_not_that_of_the_watcher() -> None:
    newer = [replace(SCENE, node=f"n{n}", zenoh_version="1.10.0") for n in range(3)]
    nodes = running(Fleet(HERE), SCENE, *newer)
    assert warnings_of(nodes) == ["! left: it has Zenoh 1.9.0, most others 1.10.0"]


def test_another_major_version_is_shown_though_it_cannot_be_read() -> None:
    fleet = Fleet(HERE)
    fleet.sample("halo/2/new/table/scene", b"\0", 0, 0.0)
    assert warnings_of(fleet.nodes(0.5, UNIX_S)) == ["! new: it speaks protocol 2, most others 1.0"]


def test_two_services_of_one_name_are_a_collision_and_a_restart_is_none() -> None:
    clone = replace(SCENE, session="s2")
    (warning,) = warnings_of(running(Fleet(HERE), SCENE, clone))
    assert warning.startswith("! left: several services have this name (sessions s1 and s2)")
    fleet = Fleet(HERE)
    running(fleet, SCENE)
    sent(fleet, clone, 2.6)
    sent(fleet, clone, 3.6)
    assert warnings_of(fleet.nodes(3.6, UNIX_S)) == []
    assert [each.session for each in fleet.nodes(6.0, UNIX_S)] == ["s2"]


def test_a_node_that_goes_is_shown_for_a_while() -> None:
    fleet = Fleet(HERE)
    sent(fleet, SCENE, 0.0)
    states = [[each.state for each in fleet.nodes(s, UNIX_S)] for s in (2.9, 3.1, GONE_S, 99.0)]
    assert states == [["running"], ["gone"], ["gone"], []]


def test_a_token_without_messages_is_a_silent_node() -> None:
    fleet = Fleet(HERE)
    key = wire.liveliness_key("left")
    fleet.token(key, alive=True, now_s=0.0)
    assert [each.state for each in fleet.nodes(1.0, UNIX_S)] == ["silent"]
    sent(fleet, SCENE, 1.0)
    assert [each.state for each in fleet.nodes(1.5, UNIX_S)] == ["running"]
    assert [each.state for each in fleet.nodes(5.0, UNIX_S)] == ["silent"]
    fleet.token(key, alive=False, now_s=5.0)
    assert [each.state for each in fleet.nodes(5.0, UNIX_S)] == ["gone"]


def test_a_node_found_by_mdns_alone_is_shown_without_values() -> None:
    fleet = Fleet(HERE)
    fleet.announced([ANNOUNCED], 0.0)
    (node,) = fleet.nodes(1.0, UNIX_S)
    assert cells(node)[:6] == ("left", "table", "announced", "?/30", "-", "-")
    assert [each.state for each in fleet.nodes(8.0, UNIX_S)] == ["gone"]
    assert fleet.nodes(GONE_S + 1.0, UNIX_S) == []


def test_a_flood_of_names_stays_bounded() -> None:
    fleet = Fleet(HERE)
    for number in range(MOST_NODES + 50):
        sent(fleet, replace(SCENE, node=f"n{number}"), number / 1000)
        fleet.token(wire.liveliness_key(f"t{number}"), alive=True, now_s=0.0)
    nodes = fleet.nodes(2.1, UNIX_S)
    assert len(nodes) == 2 * MOST_NODES
    assert {"n49", f"n{MOST_NODES + 49}"} & {each.node for each in nodes} == {f"n{MOST_NODES + 49}"}


@pytest.mark.parametrize(
    "key", ["halo/1/Left/table/scene", "halo/2/../table/scene", "halo/x/left/table/scene", "halo"]
)
def test_forged_samples_are_no_nodes(key: str) -> None:
    fleet = Fleet(HERE)
    fleet.sample(key, b"nonsense", 0, 0.0)
    fleet.token(key, alive=True, now_s=0.0)
    assert fleet.nodes(0.0, UNIX_S) == []
