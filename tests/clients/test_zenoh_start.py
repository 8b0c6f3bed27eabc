"""A Zenoh client may start before its router, and addresses that cannot be reached cost little."""

from __future__ import annotations

import json
import logging
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import zenoh

import halo_client
from halo_client.interfaces import multicast_interface
from halo_client.source import ZenohSource, parse_source
from halo_client.zenoh_input import ZenohInput, zenoh_config

NAMESPACE = f"halo{os.getpid()}"
UNREACHABLE = ["10.9.0.2", "10.9.0.3"]
OPEN = """
import time, zenoh
from halo_client.source import parse_source
from halo_client.zenoh_input import zenoh_config
began_s = time.monotonic()
try:
    zenoh.open(zenoh_config(parse_source({url!r})))
except zenoh.ZError:
    print(time.monotonic() - began_s)
"""
SERVE = """
import sys, threading
import halo_protocol as wire
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
output = ZenohOutput(ZenohSettings(**{settings!r}), "desk", "table")
scene = wire.Scene("desk", "s1", wire.VERSION, 300.0, 200.0, 2, 0, 0, 30.0)
ended = threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
while not ended.wait(0.05):
    output.send(OutgoingReport("table", scene))
output.close()
"""
RECEIVE = """
import time
import halo_client
until = time.monotonic() + 20.0
with halo_client.connect({url!r}, everything=True) as receiver:
    while time.monotonic() < until:
        for event in receiver.poll(0.05):
            print(event.message.node)
            until = 0.0
            break
"""


def test_a_client_that_starts_before_its_router_is_connected_later(
    zenoh_service: Callable[..., Any], free_tcp_port: int, caplog: pytest.LogCaptureFixture
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    with (
        caplog.at_level(logging.WARNING, "halo_client"),
        halo_client.connect(f"zenoh://?connect={endpoint}") as receiver,
    ):
        assert receiver.poll(0.05) == []
        service = zenoh_service(endpoint, mode="router")
        until = time.monotonic() + 20.0
        while not receiver.poll(0.05):
            service.tap()
            assert time.monotonic() < until
    said = [each.getMessage() for each in caplog.records]
    assert len([each for each in said if "trying again until it answers" in each]) == 1


def test_a_client_whose_router_never_starts_ends_cleanly(free_tcp_port: int) -> None:
    url = f"zenoh://?connect=tcp/127.0.0.1:{free_tcp_port}&mode=client"
    with halo_client.connect(url) as receiver:
        for _ in range(3):
            assert receiver.poll(0.01) == []
    with pytest.raises(halo_client.ClientError):
        halo_client.connect("zenoh://?connect=nonsense")


@pytest.mark.parametrize(
    ("settings", "connect", "multicast"),
    [("", ["tls/10.0.0.1:7447"], True), ("&connect=tls/10.0.0.2:1", ["tls/10.0.0.2:1"], True)],
)
def test_a_configuration_file_is_the_start_and_settings_win_over_it(
    tmp_path: Path, settings: str, connect: list[str], multicast: bool
) -> None:
    path = tmp_path / "zenoh.json5"
    file = {
        "connect": {"endpoints": ["tls/10.0.0.1:7447"]},
        "scouting": {"multicast": {"enabled": True}},
        "transport": {"link": {"tls": {"root_ca_certificate": "ca.pem"}}},
    }
    path.write_text(json.dumps(file))
    source = parse_source(f"zenoh://?mode=client&config={path}{settings}")
    assert isinstance(source, ZenohSource)
    config = zenoh_config(source)
    assert json.loads(config.get_json("connect/endpoints")) == connect
    assert json.loads(config.get_json("scouting/multicast/enabled")) is multicast
    assert json.loads(config.get_json("transport/link/tls/root_ca_certificate")) == "ca.pem"
    assert json.loads(config.get_json("mode")) == "client"


@pytest.mark.parametrize(
    ("file", "url", "mode"),
    [
        ({}, "zenoh://", "client"),
        ({}, "zenoh://?connect=tcp/10.0.0.1:7447", "client"),
        ({}, "zenoh://?connect=tcp/10.0.0.1:7447&connect=tcp/10.0.0.2:7447", "peer"),
        ({}, "zenoh://?connect=tcp/10.0.0.1:7447&listen=tcp/0.0.0.0:7447", "peer"),
        ({}, "zenoh://?connect=tcp/10.0.0.1:7447&multicast=on", "peer"),
        ({}, "zenoh://?connect=tcp/10.0.0.1:7447&mode=peer", "peer"),
        ({"connect": {"endpoints": ["tls/10.0.0.1:7447"]}}, "zenoh://?config={file}", "client"),
        ({"mode": "peer"}, "zenoh://?connect=tcp/10.0.0.1:7447&config={file}", "peer"),
        ({"mode": "client"}, "zenoh://?multicast=on&config={file}", "client"),
        ({"mode": "client"}, "zenoh://?mode=peer&config={file}", "peer"),
    ],
)
def test_one_endpoint_makes_a_client_unless_the_user_names_a_mode(
    file: dict[str, object], url: str, mode: str, tmp_path: Path
) -> None:
    path = tmp_path / "zenoh.json5"
    path.write_text(json.dumps(file))
    source = parse_source(url.format(file=path))
    assert isinstance(source, ZenohSource)
    assert json.loads(zenoh_config(source).get_json("mode")) == mode


def test_a_peer_behind_a_router_reaches_a_client_by_default(
    zenoh_service: Callable[..., Any], free_tcp_port: int
) -> None:
    """Zenoh's routers pass nothing from one peer to another."""
    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    zenoh_service(endpoint, mode="router")
    service = zenoh_service("tcp/127.0.0.1:0", connect=endpoint)
    with halo_client.connect(f"zenoh://?connect={endpoint}") as receiver:
        until = time.monotonic() + 20.0
        while not receiver.poll(0.05):
            service.tap()
            assert time.monotonic() < until


def test_a_program_that_draws_does_not_wait_for_an_address(monkeypatch: pytest.MonkeyPatch) -> None:
    def open_slowly(config: zenoh.Config) -> zenoh.Session:
        time.sleep(0.5)
        raise zenoh.ZError("no answer")

    monkeypatch.setattr(zenoh, "open", open_slowly)
    monkeypatch.setattr("halo_client.zenoh_input._RETRY_S", 0.01)
    with halo_client.connect("zenoh://?connect=tcp/10.9.0.1:7447") as receiver:
        polls, until = 0, time.monotonic() + 1.0
        while time.monotonic() < until:
            receiver.poll(0.001)
            polls += 1
    assert polls > 20, "one that waited would poll twice"


def test_by_udp_a_subscription_that_was_lost_is_declared_again(
    zenoh_service: Callable[..., Any],
    repeat: Callable[[Callable[[], object]], None],
    free_port: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Zenoh sends it once, and a packet can be lost."""
    monkeypatch.setattr("halo_client.zenoh_input._RETRY_S", 0.1)
    monkeypatch.setattr("halo_client.zenoh_input._SILENCE_S", 0.4)
    endpoint = f"udp/127.0.0.1:{free_port}"
    repeat(zenoh_service(endpoint).tap)
    source = parse_source(f"zenoh://?connect={endpoint}")
    assert isinstance(source, ZenohSource)
    with ZenohInput(source) as received:
        assert received.receive(20.0)
        assert received._open is not None
        received._open[1].pop(0).undeclare()  # as if its packet had been lost
        while received.receive(0.2):  # what has already arrived
            pass
        assert received.receive(20.0)


@pytest.mark.parametrize("mode", ["peer", "client"])
@pytest.mark.parametrize("setting", ["config=/nowhere.json5", "connect=nonsense"])
def test_what_can_never_open_is_an_error_and_not_tried_again(mode: str, setting: str) -> None:
    with pytest.raises(halo_client.ClientError, match="cannot use Zenoh with"):
        halo_client.connect(f"zenoh://?mode={mode}&{setting}")


@pytest.fixture
def network() -> Iterator[Callable[..., None]]:
    """A network namespace with a loopback and nothing else; yields `ip` inside of it."""
    tool = shutil.which("ip")
    if sys.platform != "linux" or tool is None or os.geteuid() != 0:
        pytest.skip("network namespaces need Linux, root and the ip tool")

    def ip(*words: str) -> None:
        subprocess.run([tool, *words], check=True, capture_output=True)

    try:
        ip("netns", "add", NAMESPACE)
    except subprocess.CalledProcessError:
        pytest.skip("this container allows no network namespaces")
    try:
        ip("-n", NAMESPACE, "link", "set", "lo", "up")
        yield partial(ip, "-n", NAMESPACE)
    finally:
        ip("netns", "del", NAMESPACE)


@pytest.fixture
def silent_network(network: Callable[..., None]) -> None:
    """Packets to `UNREACHABLE` vanish."""
    network("link", "add", "near", "type", "veth", "peer", "name", "far")
    for device in ("near", "far"):
        network("link", "set", device, "up")
    network("addr", "add", "10.9.0.1/24", "dev", "near")
    for number, address in enumerate(UNREACHABLE, 2):
        neighbour = (address, "lladdr", f"02:00:00:00:00:0{number}", "dev", "near")
        network("neigh", "add", *neighbour, "nud", "permanent")


def inside(script: str) -> list[str]:
    """The command that runs a script in the namespace."""
    return ["ip", "netns", "exec", NAMESPACE, sys.executable, "-c", script]


@pytest.mark.usefixtures("silent_network")
def test_an_address_that_cannot_be_reached_costs_a_second_and_not_ten() -> None:
    endpoints = "&".join(f"connect=tcp/{address}:7447" for address in UNREACHABLE)
    script = OPEN.format(url=f"zenoh://?mode=client&{endpoints}")
    done = subprocess.run(inside(script), capture_output=True, text=True, timeout=60.0)
    seconds = float(done.stdout)
    print(f"{len(UNREACHABLE)} silent addresses: {seconds:.1f} s")
    assert seconds < 2.0 * len(UNREACHABLE) + 1.0
    assert zenoh.Config().get_json("transport/unicast/open_timeout") == "10000"


@pytest.mark.usefixtures("network")
@pytest.mark.parametrize(
    ("service", "client"),
    [({}, "zenoh://"), ({"listen": ("tcp/127.0.0.1:0",), "multicast": True}, "multicast=on")],
)
def test_with_no_interface_but_the_loopback_service_and_client_find_each_other(
    service: dict[str, object], client: str
) -> None:
    """By the default endpoints, and by multicast, which Zenoh alone would not send there."""
    url = client if "://" in client else f"zenoh://?{client}"
    server = subprocess.Popen(inside(SERVE.format(settings=service)), stdin=subprocess.PIPE)
    try:
        command = inside(RECEIVE.format(url=url))
        done = subprocess.run(command, capture_output=True, text=True, timeout=60.0)
    finally:
        server.communicate(timeout=20.0)  # the end of its input ends it
    assert done.stdout == "desk\n", done.stderr


def test_other_interfaces_are_preferred_and_other_systems_choose_themselves(
    tmp_path: Path,
) -> None:
    assert multicast_interface(tmp_path) == "auto"
    for name, flags in {"lo": "0x9", "sit0": "0x80"}.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "flags").write_text(flags)
    assert multicast_interface(tmp_path) == "lo"
    (tmp_path / "sit0" / "flags").write_text("0x1003")
    assert multicast_interface(tmp_path) == "auto"
