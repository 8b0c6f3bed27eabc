"""The table, the classes and the specification agree."""

import dataclasses
import json
import math
import re
from collections.abc import Iterator
from typing import Any

import pytest

from halo_protocol import ProtocolError, decode, encode, from_json, messages, to_json
from halo_protocol.fields import range_of, unit_of
from halo_protocol.jsonview import ENUMERATIONS
from halo_protocol.table import ROWS, Row
from tests.golden import PROTOCOL, VECTORS

SPEC = (PROTOCOL / "SPEC.md").read_text()

# Version 1.0. Later versions append to these rows and never change them.
RELEASED = {
    "frame": "node session frame time_s time_frac_us count session_ms",
    "pointer": "id slot hand finger state u v x_mm y_mm hover_mm pressure vx_mm_s vy_mm_s "
    "confidence contacts force_g",
    "alive": "ids",
    "down": "id slot u v strike_mm_s ago_ms contacts",
    "up": "id slot u v ago_ms contacts",
    "scene": "node session version width_mm height_mm calibration revision source rate_hz "
    "control_port collision calibrated_s service_version zenoh_version",
    "homography": "node session revision width_px height_px projector_from_surface",
    "pose": "node session revision camera_from_surface anchor_from_surface anchored",
    "health": "node session fps latency_ms drops bad_frames tracker camera tracker_ms "
    "clock_jumps clock_error_ms profile_fit zenoh_missing write_errors memory_mb "
    "load looks_hz time_s time_frac_us nodes clock_offset_ms clock_deviation_ms",
}
RELEASED_TAGS = {
    "frame": "ssiiiii",
    "pointer": "iiiiifffffffffif",
    "alive": "",
    "down": "iiffffi",
    "up": "iifffi",
    "scene": "sssffiiifiiiss",
    "homography": "ssiiifffffffff",
    "pose": "ssi" + 24 * "f" + "i",
    "health": "ssffiiiififiiiiifiiiff",
}

rows = pytest.mark.parametrize("row", ROWS, ids=lambda row: row.kind)


@rows
def test_a_row_names_the_fields_of_its_class(row: Row) -> None:
    message: Any = row.message
    assert [field.name for field in row.fields] == [
        field.name for field in dataclasses.fields(message)
    ]


@rows
def test_a_row_begins_with_the_released_fields(row: Row) -> None:
    names = [field.name for field in row.fields]
    assert names[: row.required] == RELEASED[row.kind].split()
    assert row.tags.startswith(RELEASED_TAGS[row.kind])


@rows
def test_an_appended_field_has_a_default(row: Row) -> None:
    message: Any = row.message
    appended = dataclasses.fields(message)[row.required :]
    assert all(field.default is not dataclasses.MISSING for field in appended)


@rows
def test_only_types_that_every_client_reads_are_sent(row: Row) -> None:
    assert {field.tag for field in row.fields} <= set("ifs")


@rows
def test_a_message_survives_the_wire_and_the_view(row: Row) -> None:
    # Each argument differs from all others, so that no two can change places.
    view = {}
    for number, field in enumerate(row.fields, start=1):
        values = [number + i / 64 if field.tag == "f" else number + i for i in range(12)]
        plain = {"s": f"name-{number}", "i": number, "f": values[0]}[field.tag]
        view[field.name] = plain if field.length == 1 else values[: field.length]
    view |= {"version": "1.2.3"} if "version" in view else {}
    view |= {"session": "s1"} if "session" in view else {}
    view |= {"collision": 1} if "collision" in view else {}
    view |= {"anchored": 1} if "anchored" in view else {}
    view = {name: value for name, value in view.items() if name in RELEASED[row.kind].split()}
    message = from_json(row.kind, view)
    assert decode(encode("table", message)) == [("table", message)]
    assert from_json(row.kind, to_json(message)) == message


UNREADABLE = [
    ("alive", {}, "has no 'ids'"),
    ("alive", {"ids": 3}, "is a list"),
    ("alive", {"ids": [1, True]}, "cannot be True"),
    ("alive", {"ids": [1.0]}, "cannot be 1.0"),
    ("later", {}, "unknown message 'later'; choose from: frame, pointer"),
    ("up", {"id": "7"}, "cannot be '7'"),
    ("up", {"id": 7, "slot": 0, "u": True}, "cannot be True"),
    ("up", {"id": 7, "slot": 0, "u": 1e39}, "cannot be 1e"),
    ("up", {"id": 7, "slot": 0, "u": math.nan}, "cannot be nan"),
    (
        "pointer",
        {"id": 7, "slot": 0, "hand": "both"},
        "unknown hand 'both'; choose from: unknown, left, right",
    ),
]


@pytest.mark.parametrize(("kind", "view", "says"), UNREADABLE)
def test_an_invalid_view_is_refused(kind: str, view: dict[str, Any], says: str) -> None:
    with pytest.raises(ProtocolError, match=says):
        from_json(kind, view)


def test_each_message_has_a_row() -> None:
    classes = {row.message for row in ROWS}
    assert classes == set(messages.Message.__args__)


@rows
def test_the_specification_lists_each_argument(row: Row) -> None:
    chapter = SPEC.partition(f"### `/halo/1/{{surface}}/{row.kind}`")[2].partition("\n##")[0]
    chapter = chapter.partition("<!--")[0]
    listed = [line.split("`")[1] for line in chapter.splitlines() if line.startswith("| `")]
    assert listed == [field.name for field in row.fields]


@pytest.mark.parametrize("name", ENUMERATIONS)
def test_the_specification_lists_each_word(name: str) -> None:
    words = ", ".join(f"{member.value} `{member.name.lower()}`" for member in ENUMERATIONS[name])
    assert f"| `{name}` | `i` |  |  | {words} |" in SPEC


def test_vectors_that_the_specification_names_exist() -> None:
    chapter = SPEC.partition("## Lifetimes and faults")[2].partition("\n| how often")[0]
    cells = [line.rpartition(" | ")[2] for line in chapter.splitlines() if line.startswith("| ")]
    named = {name for cell in cells[1:] for name in re.findall(r"`([a-z-]+)`", cell)}
    known = {
        vector["name"]
        for file in ("assembly", "frames")
        for vector in json.loads((VECTORS / f"{file}.json").read_text())["vectors"]
    }
    assert len(named) > 10
    assert named <= known


def test_every_must_has_its_reason() -> None:
    lines = SPEC.splitlines()
    musts = [number for number, line in enumerate(lines) if "MUST " in line]
    assert len(musts) > 20
    for number in musts:
        assert lines[number].startswith("- ")
        assert lines[number + 1].startswith("  > Why: "), f"no reason: {lines[number]}"


def values(name: str) -> Iterator[tuple[str, float]]:
    """(field, number) of each message in a file of vectors."""
    for vector in json.loads((VECTORS / f"{name}.json").read_text())["vectors"]:
        for part in vector.get("datagrams", [vector]):
            for _, message in decode(bytes.fromhex(part["hex"])):
                for field in dataclasses.fields(message):
                    value = getattr(message, field.name)
                    for each in value if isinstance(value, tuple) else (value,):
                        if not isinstance(each, str):
                            yield field.name, each


def test_ranges_hold_for_all_vectors() -> None:
    checked = set()
    for name, value in (*values("frames"), *values("reports")):
        first, last = range_of(name)
        assert first is None or value >= first, name
        assert last is None or value <= last, name
        checked.add(name)
    fields = {field.name for row in ROWS for field in row.fields if field.tag != "s"}
    assert fields == checked, "each number of the table is in a vector"


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("x_mm", "mm"), ("vx_mm_s", "mm/s"), ("time_s", "s"), ("time_frac_us", "us"),
        ("calibrated_s", "s"),
        ("session_ms", "ms"), ("force_g", "g"), ("rate_hz", "Hz"), ("width_px", "px"), ("u", ""),
        ("contacts", ""), ("collision", ""), ("version", ""),
    ],
)  # fmt: skip
def test_the_unit_is_in_the_name(name: str, unit: str) -> None:
    assert unit_of(name) == unit
