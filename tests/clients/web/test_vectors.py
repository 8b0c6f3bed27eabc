"""halo.js reads the golden vectors as the specification says. Needs node."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import Assembler, ProtocolError, decode, event_to_json, to_json
from tests.golden import VECTORS
from tests.protocol.appended import AXIS, READ, REFUSED, SPIN

ROOT = Path(__file__).parents[3]
SCRIPT = Path(__file__).with_name("vectors.mjs")
pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def vectors(name: str, folder: Path = VECTORS) -> list[dict[str, Any]]:
    return list(json.loads((folder / f"{name}.json").read_text())["vectors"])


def read(
    datagrams: list[str], assemblies: list[list[dict[str, Any]]], script: Path = SCRIPT
) -> dict[str, Any]:
    """What halo.js makes of them; None is a refusal."""
    done = subprocess.run(
        ["node", str(script)],
        input=json.dumps({"datagrams": datagrams, "assemblies": assemblies}),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


def test_frames_reports_and_readings_are_read() -> None:
    cases: list[tuple[str, list[dict[str, Any]]]] = []
    for vector in vectors("frames"):
        for part in vector["datagrams"]:
            views = [{"surface": vector["surface"], **view} for view in part["messages"]]
            cases.append((part["hex"], views))
    for vector in vectors("reports"):
        views = [{"surface": vector["surface"], **view} for view in vector["messages"]]
        cases.append((vector["hex"], views))
    cases += [(vector["hex"], vector["messages"]) for vector in vectors("readings")]
    found = read([raw for raw, _ in cases], [])["datagrams"]
    assert found == [views for _, views in cases]


def test_malformed_datagrams_are_refused() -> None:
    cases = vectors("malformed")
    found = read([vector["hex"] for vector in cases], [])["datagrams"]
    accepted = [
        vector["name"] for vector, views in zip(cases, found, strict=True) if views is not None
    ]
    assert accepted == []


def test_a_later_reader_reads_older_minor_versions(tmp_path: Path) -> None:
    """A copy of the client, with two fields appended to `up`."""
    files = [*(ROOT / "clients" / "web").glob("*.js"), SCRIPT]
    copies = [tmp_path / file.relative_to(ROOT) for file in files]
    for file, copy in zip(files, copies, strict=True):
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, copy)
    codec = tmp_path / "clients" / "web" / "codec.js"
    row = '    up: "id:i slot:i u:f v:f ago_ms:f contacts:i'
    axis = ",".join(map(str, AXIS))
    before, found, after = codec.read_text().partition(row)
    assert found
    codec.write_text(f"{before}{row} spin:f={SPIN} axis:f3={axis}{after}")

    datagrams = [raw.hex() for raw, _ in (*READ.values(), *REFUSED.values())]
    views = [[{"kind": "up", "surface": "table", **view}] for _, view in READ.values()]
    found_views = read(datagrams, [], copies[-1])["datagrams"]
    assert found_views == [*views, *([None] * len(REFUSED))]


def test_sequences_of_datagrams_are_assembled() -> None:
    cases = vectors("assembly")
    found = read([], [vector["steps"] for vector in cases])["assemblies"]
    for vector, steps in zip(cases, found, strict=True):
        expected = [None if step.get("refusal") else step["events"] for step in vector["steps"]]
        assert steps == expected, vector["name"]


def test_mutated_datagrams_are_read_like_in_python() -> None:
    """Both readers agree on 5,000 datagrams with random faults, and neither raises."""
    chance = random.Random(5)
    seeds = []
    for folder in sorted(VECTORS.parent.glob("1.*")):  # older ones have fewer fields
        parts = [part for v in vectors("frames", folder) for part in v["datagrams"]]
        seeds += [bytes.fromhex(each["hex"]) for each in (*parts, *vectors("reports", folder))]
    mutated = [mutate(chance.choice(seeds), chance) for _ in range(5_000)]
    found = read([raw.hex() for raw in mutated], [])["datagrams"]
    for raw, views in zip(mutated, found, strict=True):
        assert views == in_python(raw), raw.hex()


def mutate(raw: bytes, chance: random.Random) -> bytes:
    changed = bytearray(raw)
    for _ in range(chance.randrange(1, 4)):
        changed[chance.randrange(len(changed))] = chance.choice([0, 1, 44, 105, 255])
    return bytes(changed)


def in_python(raw: bytes) -> list[dict[str, Any]] | None:
    try:
        messages = decode(raw)
    except ProtocolError:
        return None
    return [
        {"kind": type(message).__name__.lower(), "surface": surface, **to_json(message)}
        for surface, message in messages
    ]


def test_shuffled_streams_are_assembled_like_in_python() -> None:
    """The datagrams of all sequences, in any order, doubled and lost."""
    chance = random.Random(7)
    pool = [step["hex"] for v in vectors("assembly") for step in v["steps"] if step["hex"]]
    sequences = []
    for _ in range(40):
        chosen = [chance.choice([*pool, None]) for _ in range(100)]
        steps = [{"hex": raw, "at_s": 0.1 * i} for i, raw in enumerate(chosen)]
        sequences.append(steps)
    assert read([], sequences)["assemblies"] == [assembled(steps) for steps in sequences]


def assembled(steps: list[dict[str, Any]]) -> list[list[dict[str, Any]] | None]:
    assembler = Assembler()
    found: list[list[dict[str, Any]] | None] = []
    for step in steps:
        try:
            raw, at_s = step["hex"], step["at_s"]
            events = (
                assembler.receive_data(bytes.fromhex(raw), at_s)
                if raw
                else (assembler.expire(at_s))
            )
            found.append([event_to_json(event) for event in events])
        except ProtocolError:
            found.append(None)
    return found
