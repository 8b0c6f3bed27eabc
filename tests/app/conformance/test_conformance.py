"""Our clients pass the scripted stream, and a wrong client is found out."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import halo_client
from halo_protocol import Collision, Lost, TouchFrame, event_to_json
from halo_service.app.cli import main
from halo_service.app.conformance.expected import Line, differences, expected
from halo_service.app.conformance.play import play_udp, play_websocket
from halo_service.app.conformance.script import rules
from halo_service.errors import UserError
from tests.browser import needs_chromium, visit
from tests.ports import free_port

pytestmark = pytest.mark.slow

WEB = Path(__file__).parents[3] / "clients" / "web"
LAST = "strangers"
"""The service that is lost last."""


def lines_of(receiver: halo_client.Receiver, started: Callable[[], object]) -> list[Line]:
    """What our Python client shows until the last service is lost."""
    lines: list[Line] = []
    until = time.monotonic() + 60.0
    started()
    while not (lines and lines[-1]["kind"] == "lost" and lines[-1]["node"] == LAST):
        assert time.monotonic() < until, lines[-3:]
        events = receiver.poll(0.1)
        shown = [each for each in events if isinstance(each, TouchFrame | Lost | Collision)]
        lines += [json.loads(json.dumps(event_to_json(each))) for each in shown]
    return lines


def in_thread(action: Callable[..., Any], *arguments: Any) -> threading.Thread:
    thread = threading.Thread(target=action, args=arguments)
    thread.start()
    return thread


def test_our_python_client_passes_by_udp() -> None:
    with halo_client.connect("osc://127.0.0.1:0?follow=all") as receiver:
        port = int(receiver.url.rpartition(":")[2])
        threads: list[threading.Thread] = []
        lines = lines_of(receiver, lambda: threads.append(in_thread(play_udp, "127.0.0.1", port)))
        threads[0].join()
        assert differences(lines) == {}
        assert (receiver.losses.foreign, receiver.losses.collisions) == (5, 1)


def test_our_python_client_passes_over_a_websocket(free_tcp_port: int) -> None:
    ready = threading.Event()
    thread = in_thread(play_websocket, free_tcp_port, lambda url: ready.set())
    assert ready.wait(10.0)
    with halo_client.connect(f"ws://127.0.0.1:{free_tcp_port}?follow=all") as receiver:
        assert differences(lines_of(receiver, lambda: None)) == {}
    thread.join()


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_our_javascript_client_passes_by_udp() -> None:
    command = ["node", str(Path(__file__).with_name("conformance.mjs")), LAST]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as node:
        assert node.stdout is not None
        try:
            # Read while it is sent: a full pipe would stop node.
            thread = in_thread(play_udp, "127.0.0.1", int(node.stdout.readline()))
            lines = [json.loads(line) for line in node.stdout]
            thread.join()
        finally:
            node.kill()
    assert differences(lines) == {}


PAGE = """<!doctype html><body><script type="module">
import { connect } from "./halo.js";
const lines = [];
const add = (event) => lines.push(event);
const lost = (event) => { add(event); if (event.node === "LAST") report(lines); };
const url = decodeURIComponent(location.search.slice(1));
connect(url, { frame: add, collision: add, lost }, { everything: true });
</script></body>"""


@needs_chromium
def test_our_javascript_client_passes_in_chromium(free_tcp_port: int) -> None:
    urls: list[str] = []
    thread = in_thread(play_websocket, free_tcp_port, urls.append)
    while not urls:
        time.sleep(0.01)
    files = {each.name: each.read_text() for each in WEB.glob("*.js")}
    page = {"index.html": PAGE.replace("LAST", LAST)}
    lines = visit(files | page, f"index.html?{urls[0]}")
    thread.join()
    assert differences(lines) == {}


def test_the_expected_lines_say_what_the_script_is_for() -> None:
    """Checked by hand against the specification, without the assembler that computes them."""
    lines = expected()
    frames = {
        node: [each for each in lines if each["kind"] == "frame" and each["node"] == node]
        for node in rules()
    }
    events = {
        node: [(e["kind"], e["contacts"]) for each in shown for e in each["events"]]
        for node, shown in frames.items()
    }
    tap = [("down", 1), ("up", 1)]
    assert events["plain"] == events["double"] == events["left"] == events["restart"] == tap
    assert events["loss"] == [("down", 1), ("up", 1), ("down", 2), ("up", 2)]
    assert frames["loss"][1]["events"][0]["strike_mm_s"] == -1.0, "inferred"
    assert [each["missed"] for each in frames["loss"][:5]] == [0, 3, 2, 1, 4]
    assert [each["frame"] for each in frames["double"][:9]] == list(range(1, 10))
    last = 2**24 - 1
    numbers = [each["frame"] for each in frames["reorder"]]
    assert numbers[:5] == [last - 3, last - 1, last, 0, 1]
    assert [each["complete"] for each in frames["split"][:4]] == [True, True, False, True]
    assert [len(each["pointers"]) for each in frames["split"][:4]] == [12] * 4
    assert [len(each["pointers"]) for each in frames["many"][:3]] == [64, 64, 0]
    assert frames["major"] == []
    assert [each["frame"] for each in frames["strangers"][:2]] == [1, 3]
    assert [each["pointers"][0]["id"] for each in frames["right"][:9]] == [7] * 9
    collisions = [each for each in lines if each["kind"] == "collision"]
    assert [each["sessions"] for each in collisions] == [["s1", "s2"]]
    lost = [(each["node"], each["session"]) for each in lines if each["kind"] == "lost"]
    assert lost[0] == ("restart", "s1")
    assert sorted({node for node, _ in lost}) == sorted(set(rules()) - {"major"})


def without(lines: list[Line], node: str, number: int) -> list[Line]:
    """The lines without one of a service."""
    nth = [n for n, each in enumerate(lines) if each.get("node") == node][number]
    return lines[:nth] + lines[nth + 1 :]


def changed(lines: list[Line], node: str, **values: Any) -> list[Line]:
    """The lines with other values in the last frame of a service that has pointers."""
    nth = [n for n, each in enumerate(lines) if each.get("node") == node and each.get("pointers")]
    return [{**each, **values} if n == nth[-1] else each for n, each in enumerate(lines)]


@pytest.mark.parametrize(
    ("spoil", "node", "says"),
    [
        (lambda lines: without(lines, "loss", 1), "loss", "event 2 (frame 5): time_us is"),
        (lambda lines: without(lines, "collision", -1), "collision", "events, expected"),
        (lambda lines: changed(lines, "many", pointers=[]), "many", "pointers is []"),
        (lambda lines: changed(lines, "split", complete=False), "split", "complete is false"),
        (
            lambda lines: [*lines, {"kind": "lost", "node": "major", "session": "s1"}],
            "major",
            "1 events, expected 0",
        ),
    ],
)
def test_a_wrong_client_is_found_out(
    spoil: Callable[[list[Line]], list[Line]],
    node: str,
    says: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / "mine.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in spoil(expected())))
    assert main(["conformance", "--compare", str(path)]) == 1
    printed = capsys.readouterr().out
    assert [line for line in printed.splitlines() if line.startswith("FAIL")] == [
        f"FAIL {node}: {rules()[node]}"
    ]
    assert says in printed


def test_a_correct_client_passes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "mine.jsonl"
    assert main(["conformance", "--expected", str(path)]) == 0
    assert main(["conformance", "--compare", str(path)]) == 0
    assert capsys.readouterr().out.count("ok ") == len(rules())


@pytest.mark.parametrize("text", ["nonsense", "[]", "{}", '{"kind": 1}', '"kind"'])
def test_lines_that_cannot_be_read_are_one_sentence(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.jsonl"
    path.write_text(text)
    assert main(["conformance", "--compare", str(path)]) != 0
    assert "mine.jsonl, line 1: not an object with a 'kind'" in capsys.readouterr().err


def test_a_port_in_use_is_one_sentence(free_tcp_port: int) -> None:
    with (
        socket.create_server(("127.0.0.1", free_tcp_port)),
        pytest.raises(UserError, match="is in use; choose another one with --web PORT"),
    ):
        play_websocket(free_tcp_port)


@pytest.fixture
def free_tcp_port() -> int:
    return free_port()
