"""A recorded stream is received like a live one: at its own speed or at once, to its end."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import halo_client
from halo_client import ClientError, FileSource
from halo_client.jsonl import datagrams
from halo_protocol import Lost, TouchFrame, event_to_json
from halo_tools.monitor import main as monitor

DOWN = {"kind": "down", "id": 1, "slot": 0, "u": 0.3, "v": 0.5, "strike_mm_s": 210.0}
POINTER = {
    "id": 1, "slot": 0, "hand": "right", "finger": "index", "state": "touch", "u": 0.3, "v": 0.5,
    "x_mm": 90.0, "y_mm": 100.0, "hover_mm": 0.0, "pressure": 0.625, "vx_mm_s": 0.0,
    "vy_mm_s": 0.0, "confidence": 0.875, "contacts": 1, "force_g": -1.0,
    "diagnostics": {"signal": None},
}  # fmt: skip


def line(frame: int, pointers: list[Any] = [], events: list[Any] = []) -> dict[str, Any]:  # noqa: B006
    source = {"node": "replay", "session": "s1", "surface": "table"}
    time_us = 500_000 + frame * 40_000
    return {"time_us": time_us, **source, "frame": frame, "pointers": pointers, "events": events}


TAP = [
    line(0),
    line(1, [POINTER], [DOWN | {"ago_ms": 12.0, "contacts": 1}]),
    line(2, [POINTER]),
]


def written(folder: Path, lines: list[dict[str, Any]]) -> Path:
    path = folder / "recording.jsonl"
    path.write_text("".join(json.dumps(each) + "\n" for each in lines))
    return path


def test_a_file_is_read_to_its_end_and_its_open_touches_are_ended(tmp_path: Path) -> None:
    source = FileSource(written(tmp_path, TAP), paced=False)
    with halo_client.connect(source) as receiver:
        frames = list(receiver.frames())
        assert receiver.ended
        assert receiver.poll(0.0) == []
    assert [frame.frame for frame in frames] == [0, 1, 2, 2]
    assert [(down.strike_mm_s, down.ago_ms) for down in frames[1].downs] == [(210.0, 12.0)]
    assert frames[2].pointers[0].pressure == 0.625
    assert frames[3].pointers == () and len(frames[3].ups) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_stream_that_powershell_has_written_is_read(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "recording.jsonl"
    path.write_bytes("".join(json.dumps(each) + "\r\n" for each in TAP).encode(encoding))
    with halo_client.connect(FileSource(path, paced=False)) as receiver:
        assert len(list(receiver.frames())) == 4


def test_a_path_is_replayed_at_its_own_speed(tmp_path: Path) -> None:
    path = written(tmp_path, TAP)
    started_s = time.monotonic()
    assert len(list(halo_client.frames(str(path)))) == 4
    assert time.monotonic() - started_s >= 0.08


def test_while_the_next_frame_is_not_due_a_picture_can_be_drawn(tmp_path: Path) -> None:
    with halo_client.connect(str(written(tmp_path, [line(0), line(100)]))) as receiver:
        assert len(receiver.poll(0.01)) == 1
        assert receiver.poll(0.01) == []
        assert not receiver.ended


def test_what_the_monitor_writes_is_read_back(tmp_path: Path) -> None:
    scene = {
        "kind": "scene", "surface": "table", "node": "replay", "session": "s1",
        "version": "1.0.0", "width_mm": 300.0, "height_mm": 200.0, "calibration": "complete",
        "revision": 0, "source": "virtual", "rate_hz": 30.0, "control_port": 4257, "collision": 0,
        "calibrated_s": 0, "service_version": "", "zenoh_version": "",
    }  # fmt: skip
    with halo_client.connect(FileSource(written(tmp_path, [scene, *TAP]), False)) as receiver:
        events = [event for _ in range(5) for event in receiver.poll(0.0)]
        assert any(isinstance(event, Lost) for event in events)
    again = tmp_path / "again.jsonl"
    again.write_text("".join(json.dumps(event_to_json(event)) + "\n" for event in events))
    with halo_client.connect(FileSource(again, False)) as receiver:
        back = [event for _ in range(5) for event in receiver.poll(0.0)]
    frames = [event for event in events if isinstance(event, TouchFrame)]
    assert [event for event in back if isinstance(event, TouchFrame)][: len(frames) - 1] == (
        frames[:-1]
    )


def test_the_monitor_ends_with_the_file(tmp_path: Path, capsys: Any) -> None:
    assert monitor(["--from", str(written(tmp_path, TAP)), "--json"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 5


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"nonsense\n", "line 1, is not a frame"),
        (b"[]\n", "line 1, is not a frame"),
        (b"", "has no frames"),
        (b'\n{"kind": "lost"}\n', "has no frames"),
        (b'{"kind": "frame"}\n', "line 1, is not a frame (no 'pointers')"),
        (json.dumps(line(0)).encode() + b'\n{"pointers": 3}\n', "line 2, is not a frame"),
        (json.dumps(line(0, [{"id": 1}])).encode(), "pointer has no 'slot'"),
        (json.dumps(line(0) | {"node": "A B"}).encode(), "node must be"),
        (b"\xff\xfe\x00", "is not UTF-8 text"),
        ("Süd".encode("latin-1"), "is not UTF-8 text"),
    ],
)
def test_a_file_that_is_not_a_stream_is_one_sentence(
    content: bytes, says: str, tmp_path: Path
) -> None:
    path = tmp_path / "recording.jsonl"
    path.write_bytes(content)
    with halo_client.connect(FileSource(path, False)) as receiver, pytest.raises(ClientError) as no:
        list(receiver.frames())
    assert says in str(no.value)
    assert "\n" not in str(no.value)


def test_a_file_that_is_not_there_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(ClientError, match=r"cannot read .*none\.jsonl"):
        halo_client.connect(str(tmp_path / "none.jsonl"))


def test_a_lost_line_gives_no_datagram() -> None:
    assert datagrams({"kind": "lost", "surface": "table"}) == []


@pytest.mark.parametrize("major", [2, 17])
def test_another_major_version_is_counted_and_logged_once(
    udp_service: Callable[..., Any], caplog: pytest.LogCaptureFixture, major: int
) -> None:
    with halo_client.connect("osc://127.0.0.1:0") as receiver:
        service = udp_service(int(receiver.url.rpartition(":")[2]))
        address = f"/halo/{major}/table/frame".encode().ljust(24, b"\0")
        for _ in range(3):
            service.raw(address + b",\0\0\0")
        while receiver.losses.foreign < 3:
            assert receiver.poll(2.0) == []
    (message,) = [record.getMessage() for record in caplog.records]
    assert f"speaks protocol {major}, and this program speaks 1" in message
