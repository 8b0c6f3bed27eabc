"""OSC 1.0 as bytes: strings, bundles, arguments.

Rule: bytes are checked here. For any input the result is a value or a `ProtocolError`; the work
is bounded by the size of the datagram and `MAX_DEPTH`.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

from halo_protocol.errors import ProtocolError

Argument = int | float | str | bytes | None
"""An OSC argument; None for `N` and `I`, which have no data."""

MAX_BYTES = 65_507
"""The largest payload of a UDP datagram; also the limit on other carriers."""
MAX_DEPTH = 4
"""Depth of nested bundles that is read. Real programs use at most two."""
BUNDLE = b"#bundle\0"
IMMEDIATELY = b"\0\0\0\0\0\0\0\x01"
"""The timetag that means "now"."""

# NTP counts from 1900, Unix from 1970.
_NTP_FROM_UNIX_S = 2_208_988_800
_INT = struct.Struct(">i")
_NUMBERS = {tag: struct.Struct(f">{code}") for tag, code in zip("ihfdtc", "iqfdQi", strict=True)}
_CONSTANTS: dict[str, bool | None] = {"T": True, "F": False, "N": None, "I": None}


def timetag(time_us: int) -> bytes:
    """Microseconds since 1970 as an NTP timetag, rounded down; 0 becomes 1 January 1970."""
    seconds, rest_us = divmod(time_us, 1_000_000)
    # NTP seconds wrap in 2036; readers use them modulo 2^32.
    return struct.pack(">II", (seconds + _NTP_FROM_UNIX_S) % 2**32, (rest_us << 32) // 1_000_000)


def padded(text: str) -> bytes:
    """An OSC string: at least one zero byte, up to a multiple of four."""
    raw = text.encode()
    if b"\0" in raw:
        raise ProtocolError(f"a string cannot hold a zero byte: {text[:40]!r}")
    return raw + bytes(4 - len(raw) % 4)


def bundle(tag: bytes, *messages: bytes) -> bytes:
    """A bundle of messages."""
    sized = [_INT.pack(len(message)) + message for message in messages]
    return b"".join((BUNDLE, tag, *sized))


def message_spans(datagram: bytes) -> list[tuple[int, int]]:
    """(start, end) of each message in a datagram, in order, with nested bundles flattened."""
    if len(datagram) > MAX_BYTES:
        raise ProtocolError(f"a datagram has at most {MAX_BYTES} bytes, not {len(datagram)}")
    if not datagram:
        raise ProtocolError("the datagram is empty")
    return list(_spans(datagram, 0, len(datagram), MAX_DEPTH))


def _spans(data: bytes, start: int, end: int, depth: int) -> Iterator[tuple[int, int]]:
    if (end - start) % 4:
        raise ProtocolError(f"the size of an OSC packet must be a multiple of 4, not {end - start}")
    if not data.startswith(BUNDLE, start, end):
        yield start, end
        return
    if depth == 0:
        raise ProtocolError(f"bundles are nested more than {MAX_DEPTH} deep")
    position = start + len(BUNDLE) + 8
    if position > end:
        raise ProtocolError(f"a bundle has at least 16 bytes, not {end - start}")
    while position < end:
        (size,) = _INT.unpack_from(data, position)
        position += 4
        if not 0 < size <= end - position:
            raise ProtocolError(f"an element of {size} bytes has {end - position} bytes left")
        yield from _spans(data, position, position + size, depth - 1)
        position += size


def read_string(data: bytes, start: int, end: int) -> tuple[bytes, int]:
    """The OSC string at `start`, and where the next argument begins."""
    stop = data.find(b"\0", start, end)
    if stop < 0:
        raise ProtocolError(f"a string has no end: {data[start : min(end, start + 40)]!r}")
    following = stop + 4 - (stop - start) % 4
    if following > end:
        raise ProtocolError(f"a string is not padded to 4 bytes: {data[start:stop][:40]!r}")
    return data[start:stop], following


def read_text(data: bytes, start: int, end: int) -> tuple[str, int]:
    """Like `read_string`, as text."""
    raw, following = read_string(data, start, end)
    try:
        return raw.decode(), following
    except UnicodeDecodeError as error:
        raise ProtocolError(f"a string is not UTF-8: {raw[:40]!r}") from error


def parse_osc(datagram: bytes) -> list[tuple[str, tuple[Argument, ...]]]:
    """Any OSC message or bundle as (address, arguments), in order.

    Arrays are flattened; NaN and infinity are refused. `ProtocolError` is all it raises.
    """
    return [_message(datagram, start, end) for start, end in message_spans(datagram)]


def _message(data: bytes, start: int, end: int) -> tuple[str, tuple[Argument, ...]]:
    address, position = read_text(data, start, end)
    if not address.startswith("/"):
        raise ProtocolError(f"an OSC address begins with a slash: {address[:40]!r}")
    if position == end:
        return address, ()  # Old senders omit the tags of a message without arguments.
    tags, position = read_text(data, position, end)
    if not tags.startswith(","):
        raise ProtocolError(f"type tags begin with a comma: {tags[:40]!r}")
    arguments: list[Argument] = []
    depth = 0
    for tag in tags[1:]:
        if tag in "[]":
            depth += 1 if tag == "[" else -1
            if depth < 0:
                raise ProtocolError(f"an array ends without a start: {tags[:40]!r}")
            continue
        argument, position = _argument(tag, data, position, end)
        arguments.append(argument)
    if depth or position != end:
        raise ProtocolError(
            f"{end - position} bytes and {depth} arrays too many in {address[:40]!r}"
        )
    return address, tuple(arguments)


def _argument(tag: str, data: bytes, position: int, end: int) -> tuple[Argument, int]:
    if tag in _CONSTANTS:
        return _CONSTANTS[tag], position
    if tag in _NUMBERS:
        return _number(_NUMBERS[tag], data, position, end)
    if tag in "sS":
        return read_text(data, position, end)
    if tag == "b":
        return _blob(data, position, end)
    if tag in "rm":  # A colour and a MIDI message: four bytes each.
        return _bytes(data, position, 4, end)
    raise ProtocolError(f"unknown OSC argument type {tag!r}")


def _number(kind: struct.Struct, data: bytes, position: int, end: int) -> tuple[int | float, int]:
    if kind.size > end - position:
        raise ProtocolError(f"need {kind.size} bytes for a number, have {end - position}")
    number: int | float = kind.unpack_from(data, position)[0]
    if not math.isfinite(number):
        raise ProtocolError(f"a number must be finite, not {number}")
    return number, position + kind.size


def _blob(data: bytes, position: int, end: int) -> tuple[bytes, int]:
    size, position = _number(_INT, data, position, end)
    blob, _ = _bytes(data, position, int(size), end)
    return blob, position + (len(blob) + 3) // 4 * 4


def _bytes(data: bytes, position: int, size: int, end: int) -> tuple[bytes, int]:
    if not 0 <= size <= end - position:
        raise ProtocolError(f"need {size} bytes, have {end - position}")
    return data[position : position + size], position + size
