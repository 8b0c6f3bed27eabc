"""The JSON view: the fields of the wire under the same names, enumerations as words.

Rule: a view, not a second protocol. Replay files, `--json` and the golden vectors use it. A
number without a known word stays a number.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from halo_protocol.errors import ProtocolError
from halo_protocol.events import Collision, Event, Lost, Report
from halo_protocol.messages import (
    Calibration,
    Camera,
    Down,
    Finger,
    Hand,
    Load,
    Message,
    ProfileFit,
    Source,
    State,
    Tracker,
)
from halo_protocol.table import ROW_OF_KIND, ROW_OF_MESSAGE, Field

ENUMERATIONS: dict[str, type[IntEnum]] = {
    "hand": Hand,
    "finger": Finger,
    "state": State,
    "calibration": Calibration,
    "source": Source,
    "tracker": Tracker,
    "camera": Camera,
    "profile_fit": ProfileFit,
    "load": Load,
}
"""Field name -> its enumeration; a name means the same in every message."""

_WORDS: dict[str, dict[int, str]] = {
    name: {int(member): member.name.lower() for member in members}
    for name, members in ENUMERATIONS.items()
}
_NUMBERS = {
    name: {word: number for number, word in words.items()} for name, words in _WORDS.items()
}

_TOO_LARGE = 2.0**128
"""The smallest power of two beyond float32; comparison with NaN is false, too."""


def to_json(message: Message) -> dict[str, Any]:
    """A message as a JSON object, without its kind and surface."""
    row = ROW_OF_MESSAGE[type(message)]
    values = zip(row.fields, row.fetch(message), strict=True)
    return {field.name: _viewed(field, value) for field, value in values}


def event_to_json(event: Event) -> dict[str, Any]:
    """An event as one JSON object with its `kind`."""
    if isinstance(event, Report):
        kind = ROW_OF_MESSAGE[type(event.message)].kind
        return {"kind": kind, "surface": event.surface, **to_json(event.message)}
    if isinstance(event, Collision):
        where = {"surface": event.surface, "node": event.node}
        return {"kind": "collision", **where, "sessions": list(event.sessions)}
    source = {"surface": event.surface, "node": event.node, "session": event.session}
    if isinstance(event, Lost):
        return {"kind": "lost", **source}
    return {
        "kind": "frame",
        "time_us": event.time_us,
        **source,
        "frame": event.frame,
        "session_ms": event.session_ms,
        "pointers": [to_json(pointer) for pointer in event.pointers],
        "events": [
            {"kind": "down" if isinstance(item, Down) else "up", **to_json(item)}
            for item in event.events
        ],
        "missed": event.missed,
        "complete": event.complete,
    }


def from_json(kind: str, view: dict[str, Any]) -> Message:
    """A message from its view; unknown keys are ignored.

    `ProtocolError` if a field of 1.0 is missing or a field has the wrong type.
    """
    row = ROW_OF_KIND.get(kind)
    if row is None:
        raise ProtocolError(f"unknown message {kind!r}; choose from: {', '.join(ROW_OF_KIND)}")
    appended = [field for field in row.fields[row.required :] if field.name in view]
    fields = [*row.fields[: row.required], *appended]
    return row.message(**{field.name: _read(field, kind, view) for field in fields})


def _viewed(field: Field, value: Any) -> Any:
    if field.length != 1:
        return list(value)
    return _WORDS[field.name].get(value, int(value)) if field.name in _WORDS else value


def _read(field: Field, kind: str, view: dict[str, Any]) -> Any:
    if field.name not in view:
        raise ProtocolError(f"{kind} has no {field.name!r}")
    value = view[field.name]
    if field.length == 1:
        return _value(field, kind, value)
    if not isinstance(value, list):
        raise ProtocolError(f"{kind}: {field.name} is a list, not {value!r}"[:200])
    return tuple(_value(field, kind, item) for item in value)


def _value(field: Field, kind: str, value: Any) -> Any:
    numbers = _NUMBERS.get(field.name)
    if numbers is not None and isinstance(value, str):
        if value not in numbers:
            known = ", ".join(numbers)
            raise ProtocolError(
                f"{kind}: unknown {field.name} {value[:40]!r}; choose from: {known}"
            )
        return numbers[value]
    if not _fits(field, value):
        raise ProtocolError(f"{kind}: {field.name} cannot be {value!r}"[:200])
    return float(value) if field.tag == "f" else value


def _fits(field: Field, value: object) -> bool:
    if isinstance(value, bool):
        return False
    if field.tag == "f":
        return isinstance(value, int | float) and abs(value) < _TOO_LARGE
    return isinstance(value, str if field.tag == "s" else int)
