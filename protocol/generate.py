"""Writes the generated files: `vectors/*.json`, and the tables in `SPEC.md`.

    python protocol/generate.py           write them
    python protocol/generate.py --check   list outdated files, and fail if there is any

Only this part of the protocol reads or writes files.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vector_cases.assembly import ASSEMBLIES
from vector_cases.build import AssemblyCase, BytesCase, FrameCase, ReportCase, Step
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
    messages,
    to_json,
)
from halo_protocol.jsonview import ENUMERATIONS
from halo_protocol.table import ROW_OF_MESSAGE, ROWS, Row

HERE = Path(__file__).parent
Json = dict[str, Any]


def main(argv: list[str] | None = None) -> int:
    """Run the command; 1 where `--check` finds a difference."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--check", action="store_true", help="write nothing, compare")
    check = parser.parse_args(argv).check
    stale = [path for path, text in generated().items() if _differs(path, text)]
    for path in stale:
        sys.stdout.write(f"{'differs' if check else 'written'}: {path.relative_to(HERE)}\n")
        if not check:
            path.write_text(generated()[path], encoding="utf-8")
    return 1 if check and stale else 0


def generated() -> dict[Path, str]:
    """Path -> expected text of each generated file."""
    tables: list[tuple[str, list[Any], Callable[[Any], Json]]] = [
        ("frames", FRAMES, frame_vector),
        ("reports", REPORTS, report_vector),
        ("readings", READINGS, reading_vector),
        ("malformed", MALFORMED, malformed_vector),
        ("assembly", ASSEMBLIES, assembly_vector),
    ]
    files = {
        HERE / "vectors" / f"{name}.json": _file([vector(case) for case in cases])
        for name, cases, vector in tables
    }
    spec = HERE / "SPEC.md"
    return {**files, spec: with_tables(spec.read_text(encoding="utf-8"))}


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


def _named(case: FrameCase | ReportCase | BytesCase | AssemblyCase) -> Json:
    return {"name": case.name, "description": case.description}


def _messages(datagram: bytes) -> list[Json]:
    return [_message(message) for _, message in decode(datagram)]


def _message(message: Message) -> Json:
    return {"kind": ROW_OF_MESSAGE[type(message)].kind, **to_json(message)}


def _file(vectors: list[Json]) -> str:
    return json.dumps({"protocol": VERSION, "vectors": vectors}, indent=1) + "\n"


def _differs(path: Path, text: str) -> bool:
    return not path.exists() or path.read_text(encoding="utf-8") != text


def with_tables(spec: str) -> str:
    """The specification with its generated sections replaced."""
    for name, text in {"messages": message_tables(), "enumerations": enumerations()}.items():
        begin, end = f"<!-- generated: {name} -->\n", f"<!-- end: {name} -->\n"
        before, found, rest = spec.partition(begin)
        if not found or end not in rest:
            raise SystemExit(f"SPEC.md has no {begin.strip()} ... {end.strip()}")
        spec = f"{before}{begin}{text}{end}{rest.partition(end)[2]}"
    return spec


def message_tables() -> str:
    """One table per message: arguments in order, types and meanings."""
    return "\n".join(_message_table(row) for row in ROWS)


def _message_table(row: Row) -> str:
    docs = _documented(row.kind.capitalize())
    lines = [
        f"### `/halo/1/{{surface}}/{row.kind}`",
        "",
        f"{docs['']} Sent {row.when}.",
        "",
        "| argument | type | meaning |",
        "|---|---|---|",
    ]
    for field in row.fields:
        count = {1: "", None: " ..."}.get(field.length, f" x {field.length}")
        meaning = _enumeration(field.name) or docs[field.name]
        lines.append(f"| `{field.name}` | `{field.tag}`{count} | {meaning} |")
    return "\n".join([*lines, ""])


def _enumeration(field: str) -> str:
    """`0 hover, 1 touch`; empty if the field is not an enumeration."""
    members = ENUMERATIONS.get(field, ())
    return ", ".join(f"{member.value} `{member.name.lower()}`" for member in members)


def enumerations() -> str:
    """Explanations of single enumeration values."""
    lines = ["| field | word | meaning |", "|---|---|---|"]
    for name, members in ENUMERATIONS.items():
        docs = _documented(members.__name__)
        lines += [
            f"| `{name}` | `{member.name.lower()}` | {docs[member.name]} |"
            for member in members
            if member.name in docs
        ]
    return "\n".join([*lines, ""])


def _documented(class_name: str) -> dict[str, str]:
    """The docstrings of a class ("") and of its fields, read from its source."""
    tree = ast.parse(inspect.getsource(messages))
    body = next(n.body for n in tree.body if isinstance(n, ast.ClassDef) and n.name == class_name)
    docs = {}
    name = ""
    for node in body:
        if isinstance(node, ast.AnnAssign | ast.Assign):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            name = target.id if isinstance(target, ast.Name) else ""
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docs[name] = " ".join(str(node.value.value).split())
    return docs


if __name__ == "__main__":
    sys.exit(main())
