"""Sources of the Unity client's core: their names, recordings, leases, the bounded hand-off."""

from __future__ import annotations

import json
import socket
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import halo_client
from halo_client.lease import Lease
from halo_protocol import (
    Assembler,
    Health,
    Homography,
    Message,
    Pose,
    Scene,
    encode,
    event_to_json,
    to_json,
)
from halo_protocol.handshake import EXPIRED, WELCOME, with_token
from halo_protocol.osc import padded
from halo_service.app.conformance.script import (
    HOVERING,
    down,
    frame,
    hands,
    tap,
    touching,
    up,
)
from tests.golden import VECTORS

Run = Callable[..., list[str]]
REPORTS: list[Message] = [
    Scene("plain", "s1", "1.0.0", 300.0, 200.0, 2, 3, 2, 30.0, 4257, 0),
    Homography("plain", "s1", 3, 1920, 1080, (4.0, 0.5, 20.0, 0.25, 4.0, 10.0, 0.0, 0.0, 1.0)),
    Pose("plain", "s1", 3, tuple(map(float, range(12))), tuple(map(float, range(12, 24))), 1),
    Health("plain", "s1", 29.75, 3.5, 2, 1, 3, 1, 33.25, 1, -0.5, 2, 1, 2, 412),
]
KINDS = [(type(each).__name__.lower(), each) for each in REPORTS]
SOURCES = {
    "osc://127.0.0.1:4256": "Osc 127.0.0.1:4256 :0 frames  / False",
    "osc://0.0.0.0:5000?node=desk&surface=table": "Osc 0.0.0.0:5000 :0 frames  desk/table False",
    "osc://?hello=10.0.0.5": "Osc :0 10.0.0.5:4257 frames  / False",
    "osc://?hello=[::1]:4300&rate=30": "Osc :0 ::1:4300 frames,rate=30  / False",
    "osc://127.0.0.1:4256/?follow=all": "Osc 127.0.0.1:4256 :0 frames  / True",
    "ws://127.0.0.1:4258/halo": "WebSocket :0 :0 frames ws://127.0.0.1:4258/halo / False",
    "wss://table.example": "WebSocket :0 :0 frames wss://table.example:4258/halo / False",
    " hands.jsonl ": "File :0 :0 frames hands.jsonl / False",
    "http://127.0.0.1": "refused: unknown source 'http://127.0.0.1'",
    "hands.mkv": "refused: unknown source 'hands.mkv'",
    "osc://127.0.0.1:70000": "refused: a port is a number from 1 to 65535, not '70000'",
    "osc://127.0.0.1:x": "refused: a port is a number from 1 to 65535, not 'x'",
    "osc://127.0.0.1?colour=red": "refused: unknown setting 'colour'",
    "osc://127.0.0.1?rate=30": "refused: osc: rate needs hello=HOST:PORT",
    "ws://127.0.0.1:4258/other": "refused: ws needs a host, a port and /halo",
}


def test_sources_are_named_as_in_python(run_csharp: Run) -> None:
    found = run_csharp(list(SOURCES), "source")
    for line, wanted in zip(found, SOURCES.values(), strict=True):
        assert line.startswith(wanted) if wanted.startswith("refused") else line == wanted


def test_a_port_is_never_shared(program: list[str]) -> None:
    """Not even with a program that would share it: each would get a part of the frames."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]
        command = [*program, "live", f"osc://127.0.0.1:{port}"]
        done = subprocess.run(command, input="", capture_output=True, text=True, timeout=30)
    assert done.returncode == 2
    assert done.stderr.startswith(f"cannot listen on UDP port {port} of 127.0.0.1 (")


def recorded(path: Path) -> list[dict[str, Any]]:
    with halo_client.connect(halo_client.FileSource(path, paced=False)) as receiver:
        events = []
        while not receiver.ended:
            events += receiver.poll(0.0)
    return json.loads(json.dumps([event_to_json(event) for event in events]))


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Frames of two hands and a tap, and each kind of report."""
    path = tmp_path / "hands.jsonl"
    lines = [
        *({**to_json(each), "kind": kind, "surface": "table"} for kind, each in KINDS),
        *frames(),
    ]
    path.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    return path


def frames() -> list[dict[str, Any]]:
    assembler = Assembler()
    groups = [*tap("plain"), frame("plain", 10, hands(12)), frame("plain", 11)]
    events = [e for group in groups for raw in group for e in assembler.receive_data(raw, 0.0)]
    return [event_to_json(event) for event in events]


def test_a_recording_gives_the_events_of_python(run_csharp: Run, recording: Path) -> None:
    found = [json.loads(line) for line in run_csharp([], "recording", str(recording))]
    assert found == recorded(recording)
    assert [line["kind"] for line in found].count("frame") == 11


def test_a_recording_in_a_loop_starts_afresh(run_csharp: Run, recording: Path) -> None:
    lines = [json.loads(line) for line in run_csharp([], "recording", str(recording), "loop")]
    found = [line for line in lines if line["kind"] in ("frame", "lost")]
    first = found[: next(i for i, line in enumerate(found) if line["kind"] == "lost") + 1]
    assert len(first) == 12
    assert found[12:24] == first, "the second round is as the first"


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("{", "no JSON: a name is missing at character 2"),
        ("[1]", "an object is expected"),
        ('{"kind": "frame"}', "no 'time_us'"),
        ('{"kind": "frame", "time_us": "now"}', "'time_us' must be a number"),
        ('{"time_us": 1, "pointers": [1]}', "no 'surface'"),
        ("[" * 100, "no JSON: it is nested too deep"),
    ],
)
def test_a_bad_line_is_named(program: list[str], tmp_path: Path, line: str, reason: str) -> None:
    path = tmp_path / "hands.jsonl"
    path.write_text(f"{json.dumps(frames()[0])}\n{line}\n")
    command = [*program, "recording", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30)
    assert done.stderr.startswith(f"{path}, line 2, is no frame: {reason}")
    assert done.stdout.count('"kind": "frame"') == 1


def welcome(outcome: str, token: str, reason: str = "") -> bytes:
    texts = b"".join(map(padded, ("desk", "s1", "1.0.0", outcome, token, reason)))
    return padded(WELCOME) + padded(",ssssssi") + texts + (10_000).to_bytes(4, "big")


def test_a_lease_is_kept_and_renewed_as_in_python(run_csharp: Run) -> None:
    token = "t0123456789abcdef"
    script: list[tuple[float, bytes | None]] = [
        (0.0, None), (0.5, None), (1.0, None), (1.1, welcome("accepted", token)), (1.2, None),
        (4.2, None), (4.3, b"/halo/1/control/x\0\0\0"), (4.4, welcome("accepted", "other")),
        (4.5, with_token(EXPIRED, "other")), (4.6, with_token(EXPIRED, token)), (5.7, None),
        (5.8, welcome("warned", "second")), (5.9, b"\0" * 40), (8.9, None),
    ]  # fmt: skip
    lines = [f"{at_s} {raw.hex() if raw else '-'}" for at_s, raw in script]
    *found, goodbye = run_csharp(lines, "lease")
    lease = Lease("frames", "127.0.0.1:4257")
    for line, (at_s, raw) in zip(found, script, strict=True):
        if raw is not None:
            lease.handle(raw)
        due = lease.due(at_s)
        assert line.split()[1] == (due.hex() if due else "-"), at_s
    expected = lease.goodbye()
    assert expected is not None
    assert goodbye == expected.hex()


def test_a_refused_client_asks_no_more(run_csharp: Run) -> None:
    raw = welcome("refused", "", "hello: unknown format")
    found = run_csharp(["0 -", f"0.1 {raw.hex()}", "9 -"], "lease")
    assert found[1:] == ["Refused - hello: unknown format"] * 2 + ["-"]


def test_answers_of_the_control_port_are_read(run_csharp: Run) -> None:
    """The golden messages; a welcome that accepts starts the stream."""
    vectors = json.loads((VECTORS / "control.json").read_text())["vectors"]
    lines = [line for each in vectors for line in ("", "0 -", f"0.1 {each['hex']}")]
    found = run_csharp(lines, "lease")
    for vector, line in zip(vectors, found[1::2], strict=False):
        (message,) = vector["messages"]
        accepted = message["address"].endswith("welcome") and message["arguments"][4]
        assert (line.split()[0] == "Streaming") == bool(accepted), vector["name"]


def test_a_flood_leaves_the_newest_datagrams(run_csharp: Run) -> None:
    found = json.loads(run_csharp([], "ring")[0])
    assert found["dropped"] == 1000 - 512
    assert found["left"] == [[i, 2 + i % 2900, i] for i in range(1000 - 512, 1000)]


def test_frames_allocate_nothing(run_csharp: Run) -> None:
    """Frames of ten fingers, with touches and reports; after a warm-up of as many frames."""
    datagrams = [raw for number in range(1, 3_001) for raw in busy_frame(number)]
    found = json.loads(run_csharp([raw.hex() for raw in datagrams], "allocations")[0])
    assert found["probe"] >= 1000, "the counter counts"
    assert found["frames"] > 1_400
    assert found["bytes"] == 0


def busy_frame(number: int) -> list[bytes]:
    """One finger taps, another one comes and goes, and reports are repeated."""
    contacts = number // 10
    begun = number % 10 < 5
    tapping = touching(contacts + 1) if begun else replace(HOVERING, contacts=contacts)
    event = down(contacts + 1) if begun else up(contacts)
    coming = replace(HOVERING, id=1_000 + number // 4, slot=9)
    pointers = [tapping, coming, *hands(8)]
    repeated = [] if number % 15 else [encode("table", each) for each in REPORTS]
    return [*frame("desk", number, pointers, [event]), *repeated]
