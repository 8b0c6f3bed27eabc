"""Control messages by WebSocket: OSC as binary messages, or JSON as text.

Rule: pure, and it trusts no byte; `ValueError` or `ProtocolError` is all that it raises.
"""

from __future__ import annotations

import json
from typing import Any

import halo_protocol as wire
from halo_service.outputs.destination import Stream
from halo_service.outputs.leases import judge, welcome

Request = tuple[str, tuple[wire.Argument, ...]]
"""Address and arguments."""
MOST_ARGUMENTS = 16


def read_binary(data: bytes) -> list[Request]:
    """Read an OSC message or bundle."""
    return wire.parse_osc(data)


def read_text(text: str) -> Request:
    """Read `{"kind": "control", "address": ..., "arguments": [...]}`."""
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError("a message must be JSON") from error
    match message:
        case {"kind": "control", "address": str() as address, **rest}:
            arguments = rest.get("arguments", [])
        case _:
            raise ValueError("a message must have the kind 'control' and an address")
    if not isinstance(arguments, list) or not all(map(_fits, [address, *arguments])):
        raise ValueError("'arguments' must be a list of numbers and text")
    if len(arguments) > MOST_ARGUMENTS:
        raise ValueError(f"a message has at most {MOST_ARGUMENTS} arguments")
    return address, tuple(arguments)


def write_text(datagram: bytes) -> str:
    """Write an answer as JSON text."""
    ((address, arguments),) = wire.parse_osc(datagram)
    return json.dumps({"kind": "control", "address": address, "arguments": arguments})


def answer_hello(
    arguments: tuple[wire.Argument, ...], node: str, session: str, *, binary: bool
) -> tuple[bytes, Stream | None]:
    """Return the welcome, and the stream to send; None if the client is refused."""
    match arguments:
        case (str() as version, str() as stream, *_):
            outcome, reason, destination = judge(version, f"127.0.0.1:1/{stream}")
        case _:
            outcome, reason, destination = "refused", "a hello has a version and a stream", None
    if destination is not None and not binary and destination.stream.format != "frames":
        outcome, reason, destination = "refused", "JSON has the format frames alone", None
    answer = welcome(node, session, outcome, reason)
    return answer, destination.stream if destination else None


def _fits(value: Any) -> bool:
    """Whether OSC can hold a value."""
    if isinstance(value, str):
        return value.isprintable()
    if isinstance(value, bool):
        return False
    if isinstance(value, int):
        return -(2**31) <= value < 2**31
    return isinstance(value, float) and abs(value) < 3e38
