"""Writes the generated files: `vectors/1.0/*.json`, and the tables and examples in `SPEC.md`.

    python protocol/generate.py           write them
    python protocol/generate.py --check   list outdated files, and fail if there is any

Each minor version has its folder of vectors; those of older and of released ones are never
written again. Only this part of the protocol reads or writes files.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from spec_sections import with_sections
from vector_cases import formats
from vector_cases.assembly import ASSEMBLIES
from vector_cases.build import (
    AssemblyCase,
    BytesCase,
    ControlCase,
    FrameCase,
    ReportCase,
    Step,
)
from vector_cases.control import CONTROLS
from vector_cases.malformed import MALFORMED
from vector_cases.reading import READINGS
from vector_cases.writing import FRAMES, REPORTS

from halo_protocol import (
    VERSION,
    Assembler,
    Message,
    ProtocolError,
    decode,
    encode,
    event_to_json,
    parse_osc,
    to_json,
)
from halo_protocol.table import ROW_OF_MESSAGE
from halo_protocol.version import RELEASED

HERE = Path(__file__).parent
VECTORS = HERE / "vectors" / VERSION.rpartition(".")[0]
Json = dict[str, Any]
Named = FrameCase | ReportCase | BytesCase | AssemblyCase | ControlCase


def main(argv: list[str] | None = None) -> int:
    """Run the command; 1 where `--check` finds a difference."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--check", action="store_true", help="write nothing, compare")
    check = parser.parse_args(argv).check
    stale = [path for path, text in generated().items() if _differs(path, text)]
    if not check:
        _require_unreleased(stale)
    for path in stale:
        sys.stdout.write(f"{'differs' if check else 'written'}: {path.relative_to(HERE)}\n")
        if not check:
            path.parent.mkdir(exist_ok=True)
            path.write_text(generated()[path], encoding="utf-8")
    return 1 if check and stale else 0


def _require_unreleased(stale: list[Path]) -> None:
    minor = VECTORS.name
    if minor in RELEASED and any(path.parent == VECTORS for path in stale):
        raise SystemExit(
            f"vectors/{minor} would change, but {minor} is released: "
            "raise VERSION in halo_protocol/version.py first"
        )


def generated() -> dict[Path, str]:
    """Path -> expected text of each generated file."""
    tables: list[tuple[str, list[Any], Callable[[Any], Json]]] = [
        ("frames", FRAMES, frame_vector),
        ("reports", REPORTS, report_vector),
        ("readings", READINGS, reading_vector),
        ("malformed", MALFORMED, malformed_vector),
        ("assembly", ASSEMBLIES, assembly_vector),
        ("control", CONTROLS, control_vector),
        ("formats", formats.FORMATS, format_vector),
    ]
    files = {
        VECTORS / f"{name}.json": _file([vector(case) for case in cases])
        for name, cases, vector in tables
    }
    spec = HERE / "SPEC.md"
    return {**files, spec: with_sections(spec.read_text(encoding="utf-8"))}


def frame_vector(case: FrameCase) -> Json:
    """A frame: its datagrams, each with its messages."""
    datagrams = [
        {"messages": _messages(datagram), "hex": datagram.hex()} for datagram in case.datagrams()
    ]
    options = {"max_bytes": case.max_bytes, "timetagged": case.timetagged}
    return {**_named(case), "surface": case.surface, **options, "datagrams": datagrams}


def report_vector(case: ReportCase) -> Json:
    """A message in its own bundle; `time_us` null is the timetag "immediately"."""
    datagram = encode(case.surface, case.message, case.time_us)
    view = {"surface": case.surface, "time_us": case.time_us, "messages": _messages(datagram)}
    return {**_named(case), **view, "hex": datagram.hex()}


def reading_vector(case: BytesCase) -> Json:
    """A datagram of another program, with the messages in it."""
    found = [
        {"surface": surface, **_message(message)} for surface, message in decode(case.datagram)
    ]
    return {**_named(case), "hex": case.datagram.hex(), "messages": found}


def malformed_vector(case: BytesCase) -> Json:
    """A datagram that is refused, with the error of this reader."""
    return {**_named(case), "hex": case.datagram.hex(), "refusal": refusal(case.datagram)}


def refusal(datagram: bytes) -> str:
    """The error sentence for a malformed datagram."""
    try:
        found = decode(datagram)
    except ProtocolError as error:
        return str(error)
    raise AssertionError(f"{datagram!r} should be refused, but contains {found}")


def assembly_vector(case: AssemblyCase) -> Json:
    """Datagrams and the events of each."""
    assembler = Assembler()
    return {**_named(case), "steps": [_step(assembler, step) for step in case.steps]}


def control_vector(case: ControlCase) -> Json:
    """A message of a client or of the service."""
    view = {"sender": case.sender, "hex": case.datagram.hex(), "messages": _plain(case.datagram)}
    return {**_named(case), **view}


def format_vector(case: FrameCase) -> Json:
    """A frame of `frames.json` in other formats, each the first frame of its stream."""
    streams = {
        stream: [
            {"messages": _plain(raw), "hex": raw.hex()} for raw in formats.datagrams(case, stream)
        ]
        for stream in formats.STREAMS
    }
    text = json.loads(formats.outgoing(case).text)
    return {**_named(case), "size_mm": list(formats.SIZE_MM), **streams, "json": text}


def _plain(datagram: bytes) -> list[Json]:
    """Messages of any program: address and arguments; a timetag is an int."""
    return [
        {"address": address, "arguments": list(arguments)}
        for address, arguments in parse_osc(datagram)
    ]


def _step(assembler: Assembler, step: Step) -> Json:
    if step.datagram is None:
        events = assembler.expire(step.at_s)
        return {"at_s": step.at_s, "hex": None, "events": [event_to_json(e) for e in events]}
    view: Json = {"at_s": step.at_s, "hex": step.datagram.hex()}
    try:
        events = assembler.receive_data(step.datagram, step.at_s)
    except ProtocolError as error:
        return {**view, "refusal": str(error)}
    return {**view, "events": [event_to_json(event) for event in events]}


def _named(case: Named) -> Json:
    return {"name": case.name, "description": case.description}


def _messages(datagram: bytes) -> list[Json]:
    return [_message(message) for _, message in decode(datagram)]


def _message(message: Message) -> Json:
    return {"kind": ROW_OF_MESSAGE[type(message)].kind, **to_json(message)}


def _file(vectors: list[Json]) -> str:
    return json.dumps({"protocol": VERSION, "vectors": vectors}, indent=1) + "\n"


def _differs(path: Path, text: str) -> bool:
    return not path.exists() or path.read_text(encoding="utf-8") != text


if __name__ == "__main__":
    sys.exit(main())
