"""A Zenoh client may start before its router, and addresses that cannot be reached cost little."""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import zenoh

import halo_client

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


def test_a_client_that_starts_before_its_router_is_connected_later(
    zenoh_service: Callable[..., Any], free_tcp_port: int, caplog: pytest.LogCaptureFixture
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    with (
        caplog.at_level(logging.WARNING, "halo_client"),
        halo_client.connect(f"zenoh://?connect={endpoint}&mode=client") as receiver,
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


@pytest.fixture
def silent_network() -> Iterator[list[str]]:
    """A network namespace in which packets to `UNREACHABLE` vanish; yields its command prefix."""
    tool = shutil.which("ip")
    if sys.platform != "linux" or tool is None or os.geteuid() != 0:
        pytest.skip("network namespaces need Linux, root and the ip tool")

    def ip(*words: str) -> None:
        subprocess.run([tool, *words], check=True, capture_output=True)

    try:
        ip("netns", "add", NAMESPACE)
    except subprocess.CalledProcessError:
        pytest.skip("this container allows no network namespaces")
    inside = ("-n", NAMESPACE)
    try:
        ip(*inside, "link", "add", "near", "type", "veth", "peer", "name", "far")
        for device in ("near", "far", "lo"):
            ip(*inside, "link", "set", device, "up")
        ip(*inside, "addr", "add", "10.9.0.1/24", "dev", "near")
        for number, address in enumerate(UNREACHABLE, 2):
            neighbour = (address, "lladdr", f"02:00:00:00:00:0{number}", "dev", "near")
            ip(*inside, "neigh", "add", *neighbour, "nud", "permanent")
        yield [tool, "netns", "exec", NAMESPACE]
    finally:
        ip("netns", "del", NAMESPACE)


def test_an_address_that_cannot_be_reached_costs_a_second_and_not_ten(
    silent_network: list[str],
) -> None:
    endpoints = "&".join(f"connect=tcp/{address}:7447" for address in UNREACHABLE)
    script = OPEN.format(url=f"zenoh://?mode=client&{endpoints}")
    command = [*silent_network, sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60.0)
    seconds = float(done.stdout)
    print(f"{len(UNREACHABLE)} silent addresses: {seconds:.1f} s")
    assert seconds < 2.0 * len(UNREACHABLE) + 1.0
    assert zenoh.Config().get_json("transport/unicast/open_timeout") == "10000"
