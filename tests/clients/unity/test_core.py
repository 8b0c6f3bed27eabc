"""The Unity client's core under mono: golden vectors, random faults, the events of Python."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest

from halo_client import Began, Follow, Moved, Receiver, touches
from halo_protocol import (
    ANY,
    Alive,
    Assembler,
    Event,
    Frame,
    Message,
    Pointer,
    ProtocolError,
    TouchFrame,
    Up,
    decode,
    encode_frame,
    event_to_json,
    from_json,
    to_json,
)
from halo_protocol.osc import BUNDLE, IMMEDIATELY, message_spans
from halo_protocol.parts import Part, parts
from halo_service.app.conformance.script import HOVERING, Step, steps
from tests.clients.scripted import Script
from tests.golden import VECTORS

Run = Callable[..., list[str]]
View = dict[str, Any]


def vectors(name: str) -> list[View]:
    return list(json.loads((VECTORS / f"{name}.json").read_text())["vectors"])


def grouped(messages: list[tuple[str, Message]]) -> list[View] | None:
    """Messages as C# keeps them: parts of frames, and reports. None if they are no whole frames."""
    try:
        return [grouped_item(item) for item in parts(messages)]
    except ProtocolError:
        return None


def grouped_item(item: Any) -> View:
    if not isinstance(item, Part):
        kind = type(item.message).__name__.lower()
        return {"kind": kind, "surface": item.surface, **to_json(item.message)}
    events = [{"kind": type(each).__name__.lower(), **to_json(each)} for each in item.events]
    pointers = [to_json(each) for each in item.pointers.values()]
    head = {"kind": "part", "surface": item.surface, **to_json(item.header)}
    return {**head, "ids": list(item.ids), "pointers": pointers, "events": events}


def messages_of(views: list[View], surface: str = "") -> list[tuple[str, Message]]:
    return [(view.get("surface", surface), from_json(view["kind"], view)) for view in views]


def test_frames_and_reports_are_read(run_csharp: Run) -> None:
    cases = [
        (part["hex"], messages_of(part["messages"], vector["surface"]))
        for vector in vectors("frames")
        for part in vector["datagrams"]
    ]
    cases += [
        (each["hex"], messages_of(each["messages"], each["surface"])) for each in vectors("reports")
    ]
    found = [json.loads(line) for line in run_csharp([raw for raw, _ in cases], "decode")]
    assert found == [grouped(messages) for _, messages in cases]


def test_datagrams_of_other_programs_are_read(run_csharp: Run) -> None:
    """A message that comes without its frame is put into one, because C# reads whole frames."""
    cases = [
        in_frame(bytes.fromhex(each["hex"]), messages_of(each["messages"]))
        for each in vectors("readings")
    ]
    found = [json.loads(line) for line in run_csharp([raw.hex() for raw, _ in cases], "decode")]
    expected = [grouped(messages) for _, messages in cases]
    assert None not in expected
    assert found == expected


def in_frame(
    raw: bytes, messages: list[tuple[str, Message]]
) -> tuple[bytes, list[tuple[str, Message]]]:
    """The datagram with what its messages lack: a header before and an alive list after them."""
    surfaces = {
        surface for surface, message in messages if isinstance(message, Pointer | Up | Alive)
    }
    before, after = b"", b""
    first: list[tuple[str, Message]] = []
    last: list[tuple[str, Message]] = []
    for surface in surfaces if grouped(messages) is None else ():
        mine = [message for where, message in messages if where == surface]
        ids = [message.id for message in mine if isinstance(message, Pointer)]
        for alive in mine:
            ids = list(alive.ids) if isinstance(alive, Alive) else ids
        frame = empty_frame(surface, ids)
        first.append((surface, decode(frame[0])[0][1]))
        before += sized(frame[1])
        if not any(isinstance(message, Alive) for message in mine):
            last.append((surface, Alive(tuple(ids))))
            after += sized(frame[2])
    inner = raw[16:] if raw.startswith(BUNDLE) else sized(raw)
    return BUNDLE + IMMEDIATELY + before + inner + after, [*first, *messages, *last]


def empty_frame(surface: str, ids: list[int]) -> tuple[bytes, bytes, bytes]:
    """A frame, its header and its alive list."""
    pointers = [replace(HOVERING, id=each) for each in ids]
    (frame,) = encode_frame(surface, Frame("desk", "s1", 1, 1, 0, len(ids)), pointers)
    spans = message_spans(frame)
    header, alive = (frame[start:end] for start, end in (spans[0], spans[-1]))
    return frame, header, alive


def sized(message: bytes) -> bytes:
    return len(message).to_bytes(4, "big") + message


def test_malformed_datagrams_are_refused(run_csharp: Run) -> None:
    cases = vectors("malformed")
    found = run_csharp([each["hex"] for each in cases], "decode")
    accepted = [each["name"] for each, line in zip(cases, found, strict=True) if line != "null"]
    assert accepted == []


def test_mutated_datagrams_are_read_as_in_python(run_csharp: Run) -> None:
    """Both readers agree on 6,000 datagrams with random faults, and neither raises."""
    chance = random.Random(5)
    seeds = [bytes.fromhex(part["hex"]) for v in vectors("frames") for part in v["datagrams"]]
    seeds += [bytes.fromhex(each["hex"]) for each in vectors("reports")]
    mutated = [mutate(chance.choice(seeds), chance) for _ in range(6_000)]
    found = [json.loads(line) for line in run_csharp([raw.hex() for raw in mutated], "decode")]
    accepted = 0
    for raw, views in zip(mutated, found, strict=True):
        assert views == in_python(raw), raw.hex()
        accepted += views is not None
    assert 500 < accepted < 5_500


def mutate(raw: bytes, chance: random.Random) -> bytes:
    changed = bytearray(raw)
    for _ in range(chance.randrange(1, 4)):
        changed[chance.randrange(len(changed))] = chance.choice([0, 1, 44, 105, 127, 255])
    if chance.random() < 0.1:
        del changed[chance.randrange(len(changed)) :]
    if chance.random() < 0.1:
        changed += chance.randbytes(chance.randrange(1, 40))
    return bytes(changed)


def in_python(raw: bytes) -> list[View] | None:
    try:
        return grouped(decode(raw))
    except ProtocolError:
        return None


def test_random_bytes_are_refused(run_csharp: Run) -> None:
    chance = random.Random(6)
    heads = [
        b"",
        b"#bundle\0",
        b"#bundle\0" + bytes(8),
        b"/halo/1/table/frame\0",
        b"/halo/1/table/alive\0",
    ]
    random_bytes = [
        chance.choice(heads) + chance.randbytes(chance.randrange(200)) for _ in range(3_000)
    ]
    found = run_csharp([raw.hex() for raw in random_bytes], "decode")
    assert [json.loads(line) for line in found] == [in_python(raw) for raw in random_bytes]


def lines_of(script: list[View]) -> list[str]:
    return [f"{step['at_s']} {step['hex'] or '-'}" for step in script]


def test_sequences_of_datagrams_are_assembled(run_csharp: Run) -> None:
    cases = vectors("assembly")
    lines = [line for vector in cases for line in ("", *lines_of(vector["steps"]))]
    found = iter(run_csharp(lines, "assemble"))
    for vector in cases:
        expected = [None if step.get("refusal") else step["events"] for step in vector["steps"]]
        assert [json.loads(next(found)) for _ in expected] == expected, vector["name"]


def test_shuffled_streams_are_assembled_as_in_python(run_csharp: Run) -> None:
    """The datagrams of all sequences, in any order, doubled and lost."""
    chance = random.Random(7)
    pool = [step["hex"] for v in vectors("assembly") for step in v["steps"] if step["hex"]]
    sequences = [
        [{"hex": chance.choice([*pool, None]), "at_s": 0.1 * i} for i in range(100)]
        for _ in range(40)
    ]
    lines = [line for sequence in sequences for line in ("", *lines_of(sequence))]
    found = iter(run_csharp(lines, "assemble"))
    for sequence in sequences:
        assert [json.loads(next(found)) for _ in sequence] == assembled(sequence)


def assembled(script: list[View]) -> list[list[View] | None]:
    assembler = Assembler()
    found: list[list[View] | None] = []
    for step in script:
        raw, at_s = step["hex"], step["at_s"]
        try:
            events = (
                assembler.receive_data(bytes.fromhex(raw), at_s) if raw else assembler.expire(at_s)
            )
            found.append([event_to_json(event) for event in events])
        except ProtocolError:
            found.append(None)
    return found


def followed(
    script: list[Step], follow: Follow, monkeypatch: pytest.MonkeyPatch
) -> tuple[list[View], View]:
    now = [0.0]
    monkeypatch.setattr("halo_client.receiver.time.monotonic", lambda: now[0])
    receiver = Receiver(Script(now, script), follow)
    found = [line for _ in script for event in receiver.poll(0.0) for line in views(event)]
    return json.loads(json.dumps(found)), {
        "bad": receiver.losses.bad,
        "foreign": receiver.losses.foreign,
    }


def views(event: Event) -> Iterator[View]:
    yield event_to_json(event)
    if isinstance(event, TouchFrame):
        for touch in touches(event):
            kind = "down" if isinstance(touch, Began) else "up"
            kind = "move" if isinstance(touch, Moved) else kind
            key = touch.key
            parts = (key.node, key.surface, key.session, key.id, key.contacts)
            yield {"kind": kind, "key": "/".join(map(str, parts))}


@pytest.mark.parametrize(
    ("follow", "services"),
    [
        (Follow(), {"plain", "collision", "strangers"}),
        (Follow("restart"), {"restart"}),
        (Follow("collision"), {"collision"}),
        (Follow("right", "table"), {"right"}),
        (Follow("left", "wall"), set()),
        (Follow(everything=True), None),
    ],
    ids=["first", "restart", "collision", "node", "other-surface", "all"],
)
def test_one_service_is_followed_as_in_python(
    run_csharp: Run, follow: Follow, services: set[str] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = steps()
    lines = [f"{step.at_s} {step.datagram.hex() if step.datagram else '-'}" for step in script]
    everything = "all" if follow.everything else "first"
    head = " ".join(
        "*" if each == ANY else each for each in (follow.node, follow.surface, everything)
    )
    *found, counts = map(json.loads, run_csharp([head, *lines], "session"))
    assert (found, counts) == followed(script, follow, monkeypatch)
    assert services in (None, {each["node"] for each in found if "node" in each})
