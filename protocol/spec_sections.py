"""The generated parts of `SPEC.md`: tables of the messages, and examples from the vectors."""

from __future__ import annotations

import ast
import inspect
import struct
from collections.abc import Callable, Sequence

from vector_cases.build import FrameCase
from vector_cases.control import CONTROLS
from vector_cases.formats import FORMATS, datagrams
from vector_cases.writing import FRAMES, REPORTS

from halo_protocol import Argument, encode, messages, parse_osc
from halo_protocol.fields import range_of, unit_of
from halo_protocol.jsonview import ENUMERATIONS
from halo_protocol.osc import message_spans
from halo_protocol.table import ROWS, Field, Row

EXAMPLE = "touch-ends"
"""The frame that has each of its messages."""
FEW_LINES = 14
"""Lines of an example that is long."""


def with_sections(spec: str) -> str:
    """The specification with its generated sections replaced."""
    for name, section in SECTIONS.items():
        begin, end = f"<!-- generated: {name} -->\n", f"<!-- end: {name} -->\n"
        before, found, rest = spec.partition(begin)
        if not found or end not in rest:
            raise SystemExit(f"SPEC.md has no {begin.strip()} ... {end.strip()}")
        spec = f"{before}{begin}{section()}{end}{rest.partition(end)[2]}"
    return spec


def message_tables() -> str:
    """One table per message: arguments in order, types, units, ranges, meanings; an example."""
    reports = [encode(case.surface, case.message) for case in reversed(REPORTS)]
    frame = _frame(EXAMPLE).datagrams()
    examples = dict(line for raw in (*reports, *frame) for line in _lines(raw))
    return "\n".join(_message_table(row, examples) for row in ROWS)


def _frame(name: str) -> FrameCase:
    return next(case for case in FRAMES if case.name == name)


def _message_table(row: Row, examples: dict[str, str]) -> str:
    docs = _documented(row.kind.capitalize())
    lines = [
        f"### `/halo/1/{{surface}}/{row.kind}`",
        "",
        f"{docs['']} Sent {row.when}.",
        "",
        "| argument | type | unit | range | meaning |",
        "|---|---|---|---|---|",
    ]
    for field in row.fields:
        count = {1: "", None: " ..."}.get(field.length, f" x {field.length}")
        meaning = _enumeration(field.name) or docs[field.name]
        cells = [f"`{field.tag}`{count}", unit_of(field.name), _range(field), meaning]
        lines.append(f"| `{field.name}` | {' | '.join(cells)} |")
    example = examples[f"/halo/1/table/{row.kind}"]
    return "\n".join([*lines, "", "```", example, "```", ""])


def _range(field: Field) -> str:
    first, last = range_of(field.name)
    if field.name in ENUMERATIONS or (first is None and last is None):
        return ""
    return f"{first:g} or more" if last in (None, 2**31 - 1) else f"{first:g} to {int(last or 0)}"


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


def bytes_of_a_frame() -> str:
    """A datagram in hex, one element a line group."""
    (raw,) = _frame("empty").datagrams()
    lines = [f"{raw[:16].hex(' ', 4)}  `#bundle`, timetag 1"]
    for start, end in message_spans(raw):
        address, _ = parse_osc(raw[start:end])[0]
        lines.append(f"{raw[start - 4 : start].hex()}  {end - start} bytes: {address}")
        chunks = [raw[at : at + 16] for at in range(start, end, 16)]
        lines += [f"    {chunk.hex(' ', 4):36} {_text(chunk)}" for chunk in chunks]
    return _block(lines)


def _text(chunk: bytes) -> str:
    return "".join(chr(each) if 32 <= each < 127 else "." for each in chunk)


def examples_of(stream: str) -> Callable[[], str]:
    """A function that returns the messages of a frame in another format."""

    def example() -> str:
        case = next(case for case in FORMATS if case.name == "touch-begins")
        lines = [line for raw in datagrams(case, stream) for _, line in _lines(raw)]
        more = [f"... {len(lines) - FEW_LINES} more"] if len(lines) > FEW_LINES else []
        return _block([*lines[:FEW_LINES], *more])

    return example


def control_examples() -> str:
    """Each control message once, by who sends it."""
    lines = [f"{case.sender:7}  {line}" for case in CONTROLS for _, line in _lines(case.datagram)]
    return _block([line if len(line) <= 132 else f"{line[:128]}..." for line in lines])


def _block(lines: Sequence[str]) -> str:
    return "\n".join(["```", *lines, "```", ""])


def _lines(datagram: bytes) -> list[tuple[str, str]]:
    """(address, text) of each message: address, types and arguments, as `oscdump` prints them."""
    spans = message_spans(datagram)
    found = []
    for (start, end), (address, arguments) in zip(spans, parse_osc(datagram), strict=True):
        tags = datagram[start:end].partition(b",")[2].partition(b"\0")[0].decode()
        found.append((address, " ".join([address, f",{tags}", *map(_argument, arguments)])))
    return found


def _argument(argument: Argument) -> str:
    if isinstance(argument, str):
        return f'"{argument}"'
    if not isinstance(argument, float):
        return str(argument)
    shortest = (float(f"{argument:.{digits}g}") for digits in range(1, 10))
    return f"{next(each for each in shortest if _single(each) == argument):.9g}"


def _single(number: float) -> float:
    """A number as a float32 holds it."""
    return float(struct.unpack(">f", struct.pack(">f", number))[0])


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


SECTIONS: dict[str, Callable[[], str]] = {
    "messages": message_tables,
    "enumerations": enumerations,
    "bytes": bytes_of_a_frame,
    "flat": examples_of("flat"),
    "tuio11": examples_of("tuio11"),
    "tuio2": examples_of("tuio2"),
    "control": control_examples,
}
"""Name in `SPEC.md` -> its text."""
