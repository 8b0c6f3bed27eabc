"""The code and the golden files agree."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import (
    Alive,
    Frame,
    ProtocolError,
    decode,
    encode,
    encode_frame,
    from_json,
    to_json,
)

PROTOCOL = Path(__file__).parents[2] / "protocol"


def vectors(name: str) -> list[Any]:
    cases = json.loads((PROTOCOL / "vectors" / f"{name}.json").read_text())["vectors"]
    return [pytest.param(case, id=case["name"]) for case in cases]


def in_json(datagram: bytes) -> list[tuple[str, type, dict[str, Any]]]:
    return [(surface, type(message), to_json(message)) for surface, message in decode(datagram)]


def from_file(surface: str, views: list[dict[str, Any]]) -> list[tuple[str, type, dict[str, Any]]]:
    messages = [from_json(view["kind"], view) for view in views]
    return [(surface, type(message), to_json(message)) for message in messages]


def test_the_committed_files_are_up_to_date() -> None:
    command = [sys.executable, str(PROTOCOL / "generate.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("vector", vectors("frames"))
def test_a_frame_encodes_to_its_bytes(vector: dict[str, Any]) -> None:
    parts = [
        [from_json(view["kind"], view) for view in part["messages"]] for part in vector["datagrams"]
    ]
    by_kind: dict[str, Any] = {kind: [] for kind in ("Frame", "Pointer", "Down", "Up", "Alive")}
    for message in [message for part in parts for message in part]:
        by_kind[type(message).__name__].append(message)
    datagrams = encode_frame(
        vector["surface"],
        by_kind["Frame"][0],
        by_kind["Pointer"],
        by_kind["Down"],
        by_kind["Up"],
        max_bytes=vector["max_bytes"],
        timetagged=vector["timetagged"],
    )
    assert [datagram.hex() for datagram in datagrams] == [p["hex"] for p in vector["datagrams"]]


@pytest.mark.parametrize("vector", vectors("frames"))
def test_a_frame_decodes_to_its_messages(vector: dict[str, Any]) -> None:
    for part in vector["datagrams"]:
        assert in_json(bytes.fromhex(part["hex"])) == from_file(vector["surface"], part["messages"])


@pytest.mark.parametrize("vector", vectors("frames"))
def test_each_datagram_of_a_frame_keeps_the_rules(vector: dict[str, Any]) -> None:
    decoded = [decode(bytes.fromhex(part["hex"])) for part in vector["datagrams"]]
    assert all(len(part["hex"]) // 2 <= vector["max_bytes"] for part in vector["datagrams"])
    headers = {part[0] for part in decoded}
    alive = {part[-1] for part in decoded}
    assert len(headers) == len(alive) == 1
    ((_, header),) = headers
    assert isinstance(header, Frame)
    ((_, last),) = alive
    assert isinstance(last, Alive)
    assert header.count == len(last.ids)


@pytest.mark.parametrize("vector", vectors("reports"))
def test_a_report_is_written_and_read(vector: dict[str, Any]) -> None:
    (view,) = vector["messages"]
    datagram = encode(vector["surface"], from_json(view["kind"], view), vector["time_us"])
    assert datagram.hex() == vector["hex"]
    assert in_json(datagram) == from_file(vector["surface"], vector["messages"])


@pytest.mark.parametrize("vector", vectors("readings"))
def test_datagrams_of_other_programs_are_read(vector: dict[str, Any]) -> None:
    expected = [from_file(view["surface"], [view])[0] for view in vector["messages"]]
    assert in_json(bytes.fromhex(vector["hex"])) == expected


@pytest.mark.parametrize("vector", vectors("malformed"))
def test_malformed_datagrams_are_refused(vector: dict[str, Any]) -> None:
    with pytest.raises(ProtocolError) as refused:
        decode(bytes.fromhex(vector["hex"]))
    assert str(refused.value) == vector["refusal"]


def datagrams(*files: str) -> Iterator[Any]:
    for file in files:
        for vector in json.loads((PROTOCOL / "vectors" / f"{file}.json").read_text())["vectors"]:
            held = vector.get("datagrams") or vector.get("steps") or [vector]
            for i, holder in enumerate(held):
                if holder["hex"] is not None:
                    name = f"{file}/{vector['name']}/{i}"
                    yield pytest.param(bytes.fromhex(holder["hex"]), id=name)


@pytest.mark.parametrize("datagram", list(datagrams("frames", "reports", "readings", "assembly")))
def test_every_truncation_is_refused_or_ends_between_two_messages(datagram: bytes) -> None:
    whole = decode(datagram)
    for length in range(len(datagram)):
        try:
            read = decode(datagram[:length])
        except ProtocolError:
            continue
        assert datagram.startswith(b"#bundle\0")
        assert read == whole[: len(read)]


@pytest.mark.parametrize("datagram", list(datagrams("malformed")))
def test_every_truncation_of_a_malformed_datagram_raises_only_protocol_error(
    datagram: bytes,
) -> None:
    for length in range(len(datagram)):
        with contextlib.suppress(ProtocolError):
            decode(datagram[:length])
