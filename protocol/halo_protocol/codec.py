"""Encodes messages to bytes and decodes bytes to messages, by the table.

Rule: only the parts of a frame are named here. `encode*` refuses what `decode` would refuse, so
nothing is sent that cannot be read.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from halo_protocol.checks import CHECKS, MAX_EVENTS
from halo_protocol.errors import ProtocolError
from halo_protocol.messages import Alive, Down, Frame, Message, Pointer, Up
from halo_protocol.names import ROOT, address, check_surface
from halo_protocol.osc import (
    IMMEDIATELY,
    bundle,
    message_spans,
    padded,
    read_string,
    read_text,
    timetag,
)
from halo_protocol.table import ROW_OF_KIND, ROW_OF_MESSAGE, Row

MAX_BUNDLE = 1232
"""Default of the largest bundle in bytes: IPv6's smallest packet (1280) minus its header (40) and
UDP's (8), so no VPN or tunnel fragments it."""

_ROOT = ROOT.encode()


def encode(surface: str, message: Message, time_us: int | None = None) -> bytes:
    """A bundle of one message; its timetag is `time_us` (Unix time) or "immediately".

    Meant for scene, homography, pose and health. `ProtocolError` if a value cannot be sent.
    """
    tag = IMMEDIATELY if time_us is None else timetag(time_us)
    return bundle(tag, _encoded(surface, message))


def encode_frame(
    surface: str,
    header: Frame,
    pointers: Sequence[Pointer],
    downs: Sequence[Down] = (),
    ups: Sequence[Up] = (),
    *,
    max_bytes: int = MAX_BUNDLE,
    timetagged: bool = False,
) -> list[bytes]:
    """A frame as one or more bundles of at most `max_bytes` bytes.

    Each has the header first and the full alive list last; events go before pointers. The
    timetag is "immediately", or the frame's time if `timetagged`. `ProtocolError` if
    `header.count` is not the number of pointers, for more than 64 pointers or `MAX_EVENTS`
    events, if a value cannot be sent, and if `max_bytes` is too small for one pointer.
    """
    if header.count != len(pointers):
        raise ProtocolError(f"count is {header.count}, but there are {len(pointers)} pointers")
    if len(downs) + len(ups) > MAX_EVENTS:
        raise ProtocolError(f"a frame has at most {MAX_EVENTS} events, not {len(downs) + len(ups)}")
    first = _encoded(surface, header)
    last = _encoded(surface, Alive(tuple(pointer.id for pointer in pointers)))
    messages: list[Message] = [*downs, *ups, *pointers]
    items = [_encoded(surface, message) for message in messages]
    room = max_bytes - len(bundle(IMMEDIATELY, first, last))
    if room < max((4 + len(item) for item in items), default=0):
        raise ProtocolError(f"a bundle of {max_bytes} bytes is too small for this frame")
    tag = timetag(header.time_us) if timetagged else IMMEDIATELY
    return [bundle(tag, first, *part, last) for part in _parts(items, room)]


def _parts(items: list[bytes], room: int) -> list[list[bytes]]:
    """Split items in order, each part filled before the next; at least one part."""
    parts: list[list[bytes]] = [[]]
    left = room
    for item in items:
        size = 4 + len(item)
        if size > left:
            parts.append([])
            left = room
        parts[-1].append(item)
        left -= size
    return parts


def _encoded(surface: str, message: Message) -> bytes:
    row = ROW_OF_MESSAGE[type(message)]
    CHECKS[row.message](message)
    values = row.fetch(message)
    tags = row.tags
    if not row.plain:
        values = _flat(row, values)
        tags = "i" * len(values) if row.open_list else tags
    return _head(surface, row.kind, tags) + _packed(row, values)


@lru_cache(maxsize=256)
def _head(surface: str, kind: str, tags: str) -> bytes:
    return padded(address(surface, kind)) + padded(f",{tags}")


def _flat(row: Row, values: tuple[Any, ...]) -> tuple[Any, ...]:
    flat: list[Any] = []
    for field, value in zip(row.fields, values, strict=True):
        many = value if field.length != 1 else (value,)
        if field.length not in (None, len(many)):
            raise ProtocolError(f"{field.name} has {field.length} numbers, not {len(many)}")
        flat += many
    return tuple(flat)


def _packed(row: Row, values: tuple[Any, ...]) -> bytes:
    if row.open_list:
        return _pack(struct.Struct(f">{len(values)}i"), values, row)
    parts = []
    position = 0
    for run in row.runs:
        some = values[position : position + run.count]
        parts.append(padded(some[0]) if run.numbers is None else _pack(run.numbers, some, row))
        position += run.count
    return b"".join(parts)


def _pack(numbers: struct.Struct, values: tuple[Any, ...], row: Row) -> bytes:
    try:
        raw = numbers.pack(*values)
    except (struct.error, OverflowError) as error:
        raise ProtocolError(f"{row.kind}: {error}; {_describe(row, values)}") from error
    _require_finite(values, row)
    return raw


def _require_finite(values: tuple[Any, ...], row: Row) -> None:
    # The sum of finite float32 and int32 numbers is finite in float64.
    if not math.isfinite(sum(values)):
        raise ProtocolError(f"{row.kind}: each number must be finite; {_describe(row, values)}")


def _describe(row: Row, values: tuple[Any, ...]) -> str:
    return f"of {', '.join(field.name for field in row.fields)}: {values!r}"[:400]


def decode(datagram: bytes) -> list[tuple[str, Message]]:
    """The messages in a datagram as (surface, message), in order.

    Unknown addresses are skipped, and so are arguments after the known ones. Fields that an older
    minor version does not send have their defaults. `ProtocolError` is all it raises.
    """
    found = []
    for start, end in message_spans(datagram):
        raw_address, position = read_string(datagram, start, end)
        found_row = _row_of(raw_address)
        if found_row is not None:
            surface, row = found_row
            found.append((surface, _decoded(row, datagram, position, end)))
    return found


@lru_cache(maxsize=256)
def _row_of(raw_address: bytes) -> tuple[str, Row] | None:
    """Surface and row of an address; None for an address of another program."""
    surface, separator, kind = raw_address.removeprefix(_ROOT).partition(b"/")
    row = ROW_OF_KIND.get(kind.decode("ascii", "replace"))
    if not raw_address.startswith(_ROOT) or not separator or row is None:
        if not raw_address.startswith(b"/"):
            raise ProtocolError(f"an OSC address begins with a slash: {raw_address[:40]!r}")
        return None
    return check_surface(surface.decode("ascii", "replace")), row


def _decoded(row: Row, data: bytes, position: int, end: int) -> Message:
    tags, position = read_string(data, position, end)
    if row.open_list:
        values, position = _unpack_list(row, tags, data, position, end)
        message = row.message(values)
    else:
        if not tags.startswith(_wire_tags(row.tags)):
            row = _older(row, tags)
        values, position = _unpack(row, data, position, end)
        message = row.message(*(values if row.plain else _folded(row, values)))
    if len(tags) == 1 + len(values) and position != end:
        raise ProtocolError(f"{row.kind} has {end - position} bytes too many")
    CHECKS[row.message](message)
    return message


def _older(row: Row, tags: bytes) -> Row:
    """The row as an older minor version sends it; `ProtocolError` if none has these types."""
    for older in row.older:
        if tags == _wire_tags(older.tags):
            return older
    first = next(iter(row.older), row)
    expected = row if tags.startswith(_wire_tags(first.tags)) else first
    raise ProtocolError(f"{row.kind} must start with the types ,{expected.tags}, not {tags[:60]!r}")


@lru_cache(maxsize=64)
def _wire_tags(tags: str) -> bytes:
    return b"," + tags.encode()


def _unpack_list(
    row: Row, tags: bytes, data: bytes, position: int, end: int
) -> tuple[tuple[Any, ...], int]:
    count = len(tags) - 1
    if tags != b"," + b"i" * count:
        raise ProtocolError(f"{row.kind} is a list of ints, not {tags[:60]!r}")
    if 4 * count > end - position:
        raise ProtocolError(f"{row.kind} needs {4 * count} bytes, has {end - position}")
    return struct.unpack_from(f">{count}i", data, position), position + 4 * count


def _unpack(row: Row, data: bytes, position: int, end: int) -> tuple[tuple[Any, ...], int]:
    values: tuple[Any, ...] = ()
    for run in row.runs:
        if run.numbers is None:
            text, position = read_text(data, position, end)
            values += (text,)
            continue
        if run.numbers.size > end - position:
            raise ProtocolError(f"{row.kind} needs {run.numbers.size} bytes, has {end - position}")
        numbers = run.numbers.unpack_from(data, position)
        _require_finite(numbers, row)
        position += run.numbers.size
        values += numbers
    return values, position


def _folded(row: Row, values: tuple[Any, ...]) -> list[Any]:
    """Arguments -> the fields of a message, for rows with fields of several arguments."""
    fields: list[Any] = []
    position = 0
    for field in row.fields:
        length = field.length or 0
        some = values[position : position + length]
        fields.append(some[0] if length == 1 else some)
        position += length
    return fields
