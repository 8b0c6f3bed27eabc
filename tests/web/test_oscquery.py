"""OSCQuery as the proposal writes it, and as a client that others wrote reads it."""

from __future__ import annotations

import json
import shutil
import subprocess
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import halo_protocol as wire
from halo_protocol.fields import unit_of
from halo_protocol.table import ROWS
from halo_service.app.service.commands import Status
from halo_service.app.service.control_nodes import control_nodes
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.sensing import SensingSettings
from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings
from tests.outputs.samples import TOUCHING, frame

FOLDER = Path(__file__).parent / "oscquery_client"
SCENE = OutgoingReport("table", wire.Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0))


@pytest.fixture
def server() -> Iterator[WebServer]:
    with closing(WebServer(WebSettings(), "desk", "s1", control_port=4257)) as server:
        server.nodes = lambda: list(
            control_nodes(
                SensingSettings(),
                "desk",
                Status("desk", "s1", "1.0.0", "desk", "", 0),
                virtual=True,
            )
        )
        server.send(SCENE)
        server.send(frame(1, (replace(TOUCHING, slot=0),)))
        yield server


def get(server: WebServer, path: str, host: str = "localhost") -> Any:
    request = urllib.request.Request(
        f"http://127.0.0.1:{server.port}{path}", headers={"Host": host}
    )
    with urllib.request.urlopen(request, timeout=10.0) as answer:
        body = answer.read()
        return json.loads(body) if body else answer.status


def test_host_info_says_where_messages_go(server: WebServer) -> None:
    assert get(server, "/?HOST_INFO") == {
        "NAME": "halo desk",
        "EXTENSIONS": {
            "ACCESS": True, "VALUE": True, "RANGE": True, "DESCRIPTION": True, "UNIT": True,
        },
        "OSC_PORT": 4257,
        "OSC_TRANSPORT": "UDP",
    }  # fmt: skip


EXPECTED: list[tuple[str, dict[str, Any]]] = [
    ("/halo/1/control/pause", {"TYPE": "N", "ACCESS": 2}),
    ("/halo/1/control/profile", {"TYPE": "s", "ACCESS": 3, "VALUE": ["desk"]}),
    (
        "/halo/1/control/sensing/hover_range_mm",
        {
            "TYPE": "f", "ACCESS": 3, "VALUE": [100.0], "RANGE": [{"MIN": 0.0}],
            "UNIT": ["distance.mm"],
            "DESCRIPTION": "A fingertip is reported up to this height above the surface.",
        },
    ),
    (
        "/halo/1/control/sensing/fingers",
        {"TYPE": "s", "ACCESS": 3, "VALUE": ["index"], "RANGE": [{"VALS": ["index", "all"]}]},
    ),
    (
        "/halo/1/table/slot/0/touch",
        {"TYPE": "i", "ACCESS": 1, "VALUE": [1], "RANGE": [{"VALS": [0, 1]}]},
    ),
    ("/halo/1/table/slot/9/hover", {"TYPE": "f", "ACCESS": 1, "VALUE": [-1.0]}),
    ("/halo/1/table/count", {"TYPE": "i", "ACCESS": 1, "VALUE": [1]}),
    ("/halo/1/table/scene", {"TYPE": "sssffiiifiiiss", "ACCESS": 1}),
    ("/halo/1/table/frame", {"TYPE": "ssiiiii", "ACCESS": 1}),
    ("/halo/1/table/alive", {"TYPE": "i", "VALUE": [7], "RANGE": [{"MIN": 0, "MAX": 2**31 - 1}]}),
    ("/halo/1/table/pointer", {"TYPE": "iiiiifffffffffif", "ACCESS": 1, "VALUE": None}),
    ("/halo/1/control/hello", {"TYPE": "ssis", "ACCESS": 2}),
    ("/halo/1/control/welcome", {"TYPE": "ssssssi", "ACCESS": 1}),
    ("/halo/1/control/lease", {"TYPE": "s", "ACCESS": 2}),
    ("/halo/1/control/expired", {"TYPE": "s", "ACCESS": 1}),
    ("/halo/1/control/goodbye", {"TYPE": "s", "ACCESS": 2}),
    (
        "/halo/1/control/status",
        {"TYPE": "sssssi", "ACCESS": 3, "VALUE": ["desk", "s1", "1.0.0", "desk", "", 0]},
    ),
    (
        "/halo/1/sim/finger",
        {"TYPE": "iiffff", "ACCESS": 2, "UNIT": [None, None, *["distance.mm"] * 3, "gram"]},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("path", "attributes"), EXPECTED, ids=[path for path, _ in EXPECTED])
def test_a_node_has_the_attributes_of_the_proposal(
    server: WebServer, path: str, attributes: dict[str, Any]
) -> None:
    node = get(server, path)
    assert node["FULL_PATH"] == path
    assert {name: node.get(name) for name in attributes} == attributes


def test_the_tree_leads_to_every_node(server: WebServer) -> None:
    node = get(server, "/")
    assert (node["FULL_PATH"], node["ACCESS"]) == ("/", 0)
    for part in ("halo", "1", "table", "scene"):
        node = node["CONTENTS"][part]
    assert node["VALUE"][:5] == ["desk", "s1", "1.0.0", 300.0, 200.0]
    assert node["UNIT"][3:5] == ["distance.mm", "distance.mm"]


def leaves(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if "CONTENTS" not in node:
        yield node
    for each in node.get("CONTENTS", {}).values():
        yield from leaves(each)


def test_each_node_is_complete(server: WebServer) -> None:
    found = {node["FULL_PATH"]: node for node in leaves(get(server, "/"))}
    for path, node in found.items():
        assert node.keys() >= {"TYPE", "ACCESS", "DESCRIPTION"}, path
        count = 0 if node["TYPE"] == "N" else len(node["TYPE"])
        for name in {"VALUE", "RANGE", "UNIT"} & node.keys():
            assert len(node[name]) == count, (path, name)
    for row in ROWS:
        for field in row.fields:
            node = found[f"/halo/1/table/{row.kind}"]
            assert "RANGE" in node, row.kind
            assert not unit_of(field.name) or "UNIT" in node, row.kind


def test_a_control_port_elsewhere_is_named() -> None:
    with closing(WebServer(WebSettings(), "desk", "s1", control_host="127.0.0.9")) as server:
        assert get(server, "/?HOST_INFO")["OSC_IP"] == "127.0.0.9"


def test_one_attribute_can_be_asked_for(server: WebServer) -> None:
    path = "/halo/1/control/sensing/up_level"
    assert get(server, f"{path}?VALUE") == {"VALUE": [0.1]}
    assert get(server, f"{path}?ACCESS") == {"ACCESS": 3}
    assert get(server, "/halo/1/table/health?VALUE") == 204, "there is none yet"


@pytest.mark.parametrize(
    ("path", "host", "status"),
    [
        ("/halo/1/wall", "localhost", 404),
        ("/halo/1/table/count?SECRET", "localhost", 400),
        ("/", "evil.example", 403),
    ],
)
def test_wrong_requests_are_refused(server: WebServer, path: str, host: str, status: int) -> None:
    with pytest.raises(urllib.error.HTTPError) as refused:
        get(server, path, host)
    with closing(refused.value):
        assert refused.value.code == status


@pytest.mark.skipif(
    shutil.which("node") is None or not (FOLDER / "node_modules" / "oscquery").is_dir(),
    reason="oscquery is not installed: npm install in tests/web/oscquery_client",
)
def test_a_client_that_others_wrote_reads_the_namespace(server: WebServer) -> None:
    done = subprocess.run(
        ["node", "read.js", str(server.port)],
        cwd=FOLDER, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    read = json.loads(done.stdout)
    assert (read["host"]["name"], read["host"]["oscPort"]) == ("halo desk", 4257)
    nodes = read["nodes"]
    assert nodes["/halo/1/table/slot/0/touch"]["values"] == [1]
    assert nodes["/halo/1/table/scene"]["values"][:3] == ["desk", "s1", "1.0.0"]
    hover = nodes["/halo/1/control/sensing/hover_range_mm"]
    assert (hover["values"], hover["ranges"][0]["min"]) == ([100], 0)
    assert "/halo/1/control/pause" in nodes
