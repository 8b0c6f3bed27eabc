"""Who finds the streams, in two network namespaces with a cable between them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

HERE, THERE = "halo-lsl-here", "halo-lsl-there"
FIND = "import pylsl; print(sorted(each.name() for each in pylsl.resolve_streams(1.5)))"
ALL = "['halo-contacts', 'halo-markers', 'halo-pointers']"
STREAMS = """
import time
from halo_lsl.clock import Kind
from halo_lsl.outlets import Outlets, configure
from halo_lsl.streams import Setup
configure(local={local})
with Outlets(Setup("desk", "table", None, 30.0, Kind.HOST, 0.05, 0.0)):
    print("ready", flush=True)
    time.sleep(60.0)
"""


@pytest.fixture
def cable() -> Iterator[None]:
    """Two machines, each with an address and a route to the other."""
    tool = shutil.which("ip")
    if tool is None or os.geteuid() != 0:
        pytest.skip("network namespaces need root and iproute2")

    def ip(*words: str) -> None:
        subprocess.run([tool, *words], check=True, capture_output=True)

    try:
        ip("netns", "add", HERE)
    except subprocess.CalledProcessError:
        pytest.skip("this container allows no network namespaces")
    try:
        ip("netns", "add", THERE)
        ip("link", "add", "lsl0", "netns", HERE, "type", "veth", "peer", "lsl1", "netns", THERE)
        for number, (name, device) in enumerate(((HERE, "lsl0"), (THERE, "lsl1")), start=1):
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "link", "set", device, "up")
            ip("-n", name, "addr", "add", f"10.99.0.{number}/24", "dev", device)
            ip("-n", name, "route", "add", "default", "dev", device)
        yield
    finally:
        for name in (HERE, THERE):
            subprocess.run([tool, "netns", "del", name], check=False, capture_output=True)


def inside(name: str, script: str) -> list[str]:
    return ["ip", "netns", "exec", name, sys.executable, "-c", script]


@pytest.mark.long
@pytest.mark.usefixtures("cable")
@pytest.mark.parametrize(("local", "there"), [(False, ALL), (True, "[]")])
def test_another_machine_finds_the_streams_unless_they_are_local(
    local: bool, there: str, tmp_path: Path
) -> None:
    configuration = tmp_path / "lsl_api.cfg"  # liblsl's defaults, with less output
    configuration.write_text("[log]\nlevel = -3\n")
    with subprocess.Popen(inside(HERE, STREAMS.format(local=local)), stdout=subprocess.PIPE) as run:
        try:
            assert run.stdout is not None
            assert run.stdout.readline() == b"ready\n"
            time.sleep(0.5)
            for name, found in ((HERE, ALL), (THERE, there)):
                done = subprocess.run(
                    inside(name, FIND), capture_output=True, text=True, timeout=30,
                    env=os.environ | {"LSLAPICFG": str(configuration)},
                )  # fmt: skip
                assert done.stdout.strip() == found, name
        finally:
            run.kill()
