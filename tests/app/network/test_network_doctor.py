"""The doctor explains a network: each fault is one sentence with its remedy."""

from __future__ import annotations

import json
import socket
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from ipaddress import IPv4Interface
from pathlib import Path

import pytest

from halo_client import ZenohSource
from halo_service.app.cli import main
from halo_service.app.doctor import NETWORK, Finding, format_finding
from halo_service.app.fleet.node import Node, Versions
from halo_service.app.network import interfaces, ports, reach
from halo_service.app.network.interfaces import Card
from halo_service.app.network.nodes import Received, findings
from halo_service.app.network.ports import zenoh_ports
from halo_service.outputs.settings import ZenohSettings
from tests.app.bridge.test_bridge import opened_router

CARDS = [
    Card("lo", (IPv4Interface("127.0.0.1/8"),)),
    Card("eth0", (IPv4Interface("192.168.20.20/24"),)),
]
DESK = Node(
    "desk", "table", "s1", "running", "zenoh", 0.0, 4.0, versions=Versions("1.1.0", "0.1", "1.10.2")
)


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (ConnectionRefusedError(), "nothing listens at this port; start the router or service"),
        (TimeoutError(), "no answer within 2 s; compare the address"),
        (socket.gaierror(), "the name 'table.lab' is unknown here; write the machine's address"),
        (
            OSError(101, "Network is unreachable"),
            "there is no way to it (Network is unreachable); this machine is in 127.0.0.0/8, "
            "192.168.20.0/24",
        ),
    ],
)
def test_each_error_of_a_connection_has_its_own_remedy(error: OSError, says: str) -> None:
    finding = Finding("tcp/table.lab:7447", False, *reach._explained(error, "table.lab", CARDS))
    assert says in format_finding(finding, NETWORK)


@pytest.mark.parametrize(
    ("node", "frames", "missed", "mark", "says"),
    [
        (DESK, 120, 0, "ok", "30 frames/s, 0.0 % lost, protocol 1.1.0, Zenoh 1.10.2"),
        (DESK, 114, 6, "note", "28 frames/s, 5.0 % lost"),
        (DESK, 60, 60, "fail", "50.0 % lost"),
        (DESK, 0, 0, "fail", "no frames arrive"),
        (replace(DESK, clock_ms=-80.0), 120, 0, "note", "its clock -80 ms; let both machines"),
        (replace(DESK, state="announced", address="10.0.0.5:4257"), 0, 0, "note", "10.0.0.5:4257"),
    ],
)
def test_a_node_is_judged_by_what_arrives(
    node: Node, frames: int, missed: int, mark: str, says: str
) -> None:
    key = (node.node, node.surface)
    fewer = Counter({key: frames // 2}), Counter[tuple[str, str]]()  # the same node, by another way
    received = Received(4.0, (node,), [fewer, (Counter({key: frames}), Counter({key: missed}))])
    (line,) = [format_finding(each, NETWORK) for each in findings(received)]
    assert line.startswith(mark)
    assert says in line


def test_warnings_of_a_node_are_faults() -> None:
    warned = DESK.warned("several services have this name")
    received = Received(1.0, (warned, warned), [(Counter({("desk", "table"): 30}), Counter())])
    assert [each.good for each in findings(received)] == [True, False]


@pytest.mark.parametrize(
    ("listen", "mark", "says"),
    [
        ("tcp/127.0.0.1:{port}", "note", "is free, for programs of this machine only"),
        ("tcp/0.0.0.0:{port}", "ok", "is free"),
        ("tcp/127.0.0.1:{taken}", "fail", "another program has it; set [zenoh] listen"),
        ("nonsense", "fail", "write it as tcp/0.0.0.0:7447"),
    ],
)
def test_the_own_port_is_checked(
    listen: str, mark: str, says: str, free_port: Callable[[], int], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(interfaces, "UFW", tmp_path / "ufw.conf")
    monkeypatch.setattr(interfaces, "FIREWALLD", tmp_path / "firewalld")
    with closing(socket.create_server(("127.0.0.1", 0))) as other:
        endpoint = listen.format(port=free_port(), taken=other.getsockname()[1])
        (finding,) = zenoh_ports(ZenohSettings(listen=(endpoint,)), CARDS, answers=False)
    line = format_finding(finding, NETWORK)
    assert line.startswith(mark)
    assert says in line


def test_the_default_port_of_another_program_is_only_a_note(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with closing(socket.create_server(("127.0.0.1", 0))) as other:
        monkeypatch.setattr(ports, "LISTEN", (f"tcp/127.0.0.1:{other.getsockname()[1]}",))
        (finding,) = zenoh_ports(ZenohSettings(), CARDS, answers=False)
    line = format_finding(finding, NETWORK)
    assert line.startswith("note")
    assert "a service uses the next free port" in line


def test_a_firewall_that_is_on_is_named_with_its_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (ufw := tmp_path / "ufw.conf").write_text("ENABLED=yes\nLOGLEVEL=low\n")
    monkeypatch.setattr(interfaces, "UFW", ufw)
    settings = ZenohSettings(listen=("udp/0.0.0.0:7447",))
    (finding,) = zenoh_ports(settings, CARDS, answers=True)
    assert "ufw is on: sudo ufw allow 7447/udp" in format_finding(finding, NETWORK)


def test_a_router_of_another_zenoh_is_named(
    free_port: Callable[[], int], monkeypatch: pytest.MonkeyPatch
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    source = ZenohSource((endpoint,), mode="client")
    with opened_router(endpoint, adminspace=True):
        (who, trips), answers = reach.reach(source, CARDS)
        monkeypatch.setattr(reach, "zenoh_version", lambda: "1.2.0")
        (other, _), _ = reach.reach(source, CARDS)
    assert answers
    assert who.good
    assert who.state.startswith("a router with Zenoh 1.")
    assert "ms, at most" in trips.state
    assert not other.good
    assert "install the same minor version" in other.remedy
    (gone,), answers = reach.reach(source, CARDS)
    assert not answers
    assert "nothing listens at this port" in gone.state


def test_the_command_prints_lines_or_json_and_fails_with_a_fault(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.app.network.examine.SECONDS", 0.1)
    assert main(["doctor", "--network", "--json", "--connect", "nonsense"]) == 1
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    (fault,) = [each for each in lines if each["what"] == "nonsense"]
    assert not fault["good"]
    assert fault["remedy"].startswith("write endpoints as")
    assert main(["doctor", "--connect", "tcp/127.0.0.1:1"]) == 2
    assert "--connect needs --network" in capsys.readouterr().err
