"""`halo list` finds services by mDNS and by Zenoh, and skips what is no service."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

import halo_protocol as wire
from halo_service.app.cli import main
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
from halo_service.web.announcement import OSC, Announcement, Port

SCENE = OutgoingReport("table", wire.Scene("right", "s2", "1.0.0", 300.0, 200.0, 2, 0, 0, 15.0))
FOREIGN = {"surface": "no/name", "rate_hz": "x"}
FACTS = {"surface": "table", "rate_hz": "30"}


@pytest.fixture
def config(tmp_path: Path, free_port: Callable[[], int]) -> Iterator[Path]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    path = tmp_path / "halo.toml"
    path.write_text(f'[zenoh]\nconnect = ["{endpoint}"]\n')
    port = [Port(OSC, "127.0.0.1", 4257)]
    settings = ZenohSettings(listen=(endpoint,))
    with (
        closing(Announcement(NameWatch("left", "s1"), port, FACTS)) as left,
        closing(
            Announcement(NameWatch("stranger", "s1"), port, {"surface": "no/name", "rate_hz": "x"})
        ) as bad,
        closing(ZenohOutput(settings, "right", "table")) as right,
    ):
        right.send(SCENE)
        left._thread.join()
        bad._thread.join()
        yield path


def test_services_are_found_by_mdns_and_zenoh(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["list", "--json", "--config", str(config)]) == 0
    found = {line["node"]: line for line in map(json.loads, capsys.readouterr().out.splitlines())}
    assert found["left"] == {
        "node": "left", "surface": "table", "session": "s1", "rate_hz": 30.0, "by": "mdns",
        "address": "127.0.0.1:4257",
    }  # fmt: skip
    assert found["right"] == {
        "node": "right", "surface": "table", "session": "s2", "rate_hz": 15.0, "by": "zenoh",
        "address": "halo/1/right/table/scene",
    }  # fmt: skip
    assert "stranger" not in found
    assert main(["list", "--config", str(config)]) == 0
    assert "left  table  30 Hz  mdns 127.0.0.1:4257" in capsys.readouterr().out
