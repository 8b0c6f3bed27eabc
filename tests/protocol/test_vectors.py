"""The code and the golden files agree."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_message import OscMessage

from halo_protocol import (
    VERSION,
    Alive,
    Frame,
    ProtocolError,
    decode,
    encode,
    encode_frame,
    from_json,
    parse_osc,
    to_json,
)
from halo_protocol.handshake import CONTROL, EXPIRED, LEAST_HELLO, with_token
from halo_protocol.table import ROWS
from halo_service.app.service.commands import Status
from halo_service.outputs.destination import FORMATS
from halo_service.outputs.leases import welcome
from tests.golden import PROTOCOL, VECTORS


def vectors(name: str) -> list[Any]:
    cases = json.loads((VECTORS / f"{name}.json").read_text())["vectors"]
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


def loaded(folder: Path, name: str) -> list[dict[str, Any]]:
    return list(json.loads((folder / f"{name}.json").read_text())["vectors"])


RELEASED = sorted(path for path in VECTORS.parent.iterdir() if path.name.startswith("1."))
"""A folder for each minor version; this reader must read all of them."""


@pytest.mark.parametrize("folder", RELEASED, ids=lambda folder: folder.name)
def test_vectors_of_each_released_minor_version_are_read(folder: Path) -> None:
    holders = [part for vector in loaded(folder, "frames") for part in vector["datagrams"]]
    for holder in (*holders, *loaded(folder, "reports"), *loaded(folder, "readings")):
        found = [to_json(message) for _, message in decode(bytes.fromhex(holder["hex"]))]
        for view, expected in zip(found, holder["messages"], strict=True):
            expected = {k: v for k, v in expected.items() if k not in ("kind", "surface")}
            assert {name: view[name] for name in expected} == expected
    for vector in loaded(folder, "malformed"):
        with pytest.raises(ProtocolError):
            decode(bytes.fromhex(vector["hex"]))


def test_each_message_and_each_format_has_a_vector() -> None:
    frames, reports = loaded(VECTORS, "frames"), loaded(VECTORS, "reports")
    holders = [part for vector in frames for part in vector["datagrams"]] + reports
    kinds = {message["kind"] for holder in holders for message in holder["messages"]}
    assert kinds == {row.kind for row in ROWS}
    for vector in loaded(VECTORS, "formats"):
        streams = {name.partition(",")[0] for name in vector if isinstance(vector[name], list)}
        assert set(FORMATS) - {"frames"} <= streams
    addresses = {each["messages"][0]["address"] for each in loaded(VECTORS, "control")}
    settings = {address for address in addresses if "/sensing/" in address}
    assert addresses - settings == {
        CONTROL + name
        for name in (
            "hello", "welcome", "lease", "expired", "goodbye",
            "pause", "resume", "background", "profile", "status",
        )
    }  # fmt: skip
    assert settings


def plain(folder: Path) -> Iterator[Any]:
    """Datagrams that are no frames or reports, with their messages."""
    for vector in loaded(folder, "control"):
        yield pytest.param([vector], id=vector["name"])
    for vector in loaded(folder, "formats"):
        for stream in ("flat", "flat,bundles=off", "tuio11", "tuio2"):
            yield pytest.param(vector[stream], id=f"{vector['name']}/{stream}")


@pytest.mark.parametrize("parts", list(plain(VECTORS)))
def test_python_osc_reads_control_messages_and_other_formats(parts: list[dict[str, Any]]) -> None:
    for part in parts:
        raw = bytes.fromhex(part["hex"])
        expected = [(each["address"], each["arguments"]) for each in part["messages"]]
        assert [(address, list(values)) for address, values in parse_osc(raw)] == expected
        theirs = list(OscBundle(raw)) if raw.startswith(b"#bundle") else [OscMessage(raw)]
        for message, (address, arguments) in zip(theirs, expected, strict=True):
            assert message.address == address
            # It splits a timetag into two parts.
            pairs = zip(message.params, arguments, strict=True)
            assert all(a == b for a, b in pairs if not isinstance(a, tuple))


@pytest.mark.parametrize("vector", loaded(VECTORS, "control"), ids=lambda vector: vector["name"])
def test_no_answer_is_larger_than_its_question(vector: dict[str, Any]) -> None:
    questions = {"welcome": LEAST_HELLO, "status": LEAST_HELLO, "expired": 48}
    name = vector["messages"][0]["address"].removeprefix(CONTROL)
    if vector["sender"] == "service":
        assert len(vector["hex"]) // 2 <= questions[name]


SERVICE_BYTES = {
    "welcome": welcome("desk", "s1", "accepted", "", "t0123456789abcdef", 10.0),
    "expired": with_token(EXPIRED, "t0123456789abcdef"),
    "status": Status("desk", "s1", VERSION, "desk", "", 1).packed(),
    "status-with-error": Status(
        "desk", "s1", VERSION, "", "send the name of a profile, such as desk", 0
    ).packed(),
}


@pytest.mark.parametrize("name", SERVICE_BYTES)
def test_the_service_sends_the_bytes_of_its_control_vectors(name: str) -> None:
    vectors = {vector["name"]: vector["hex"] for vector in loaded(VECTORS, "control")}
    assert SERVICE_BYTES[name].hex() == vectors[name]


def datagrams(*files: str) -> Iterator[Any]:
    for file in files:
        for vector in loaded(VECTORS, file):
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
