"""Reading of any OSC message, with bounded work."""

import struct
from typing import Any

import pytest
from pythonosc.osc_message_builder import OscMessageBuilder

from halo_protocol import Argument, ProtocolError, parse_osc
from halo_protocol.osc import IMMEDIATELY, MAX_BYTES, bundle, padded


def message(tags: str, *raw: bytes) -> bytes:
    return b"".join((padded("/halo/1/control/x"), padded(f",{tags}"), *raw))


READ = [
    ("", (), ()),
    ("i", (b"\xff\xff\xff\xfe",), (-2,)),
    ("f", (struct.pack(">f", 0.5),), (0.5,)),
    ("h", (struct.pack(">q", -(2**40)),), (-(2**40),)),
    ("d", (struct.pack(">d", 0.1),), (0.1,)),
    ("t", (IMMEDIATELY,), (1,)),
    ("c", (struct.pack(">i", 65),), (65,)),
    ("s", (padded("desk"),), ("desk",)),
    ("S", (padded(""),), ("",)),
    ("b", (struct.pack(">i", 5), b"abcde\0\0\0"), (b"abcde",)),
    ("b", (struct.pack(">i", 0),), (b"",)),
    ("r", (b"\1\2\3\4",), (b"\1\2\3\4",)),
    ("m", (b"\1\2\3\4",), (b"\1\2\3\4",)),
    ("TFNI", (), (True, False, None, None)),
    ("i[ii[f]]s", (bytes(16), padded("z")), (0, 0, 0, 0.0, "z")),
]


@pytest.mark.parametrize(("tags", "raw", "arguments"), READ, ids=[case[0] for case in READ])
def test_every_type_of_argument_is_read(
    tags: str, raw: tuple[bytes, ...], arguments: tuple[Argument, ...]
) -> None:
    assert parse_osc(message(tags, *raw)) == [("/halo/1/control/x", arguments)]


@pytest.mark.parametrize(("tags", "raw", "arguments"), READ, ids=[case[0] for case in READ])
def test_no_argument_is_read_beyond_the_end(
    tags: str, raw: tuple[bytes, ...], arguments: tuple[Argument, ...]
) -> None:
    whole = message(tags, *raw)
    for missing in range(4, len(b"".join(raw)) + 1, 4):
        with pytest.raises(ProtocolError):
            parse_osc(whole[:-missing])
    with pytest.raises(ProtocolError):
        parse_osc(whole + bytes(4))


def test_python_osc_agrees_on_a_message_of_many_types() -> None:
    builder = OscMessageBuilder("/x")
    sent: list[tuple[str, Any]] = [
        ("i", 3),
        ("f", 0.25),
        ("s", "ä"),
        ("b", b"123"),
        ("h", 2**40),
        ("T", True),
        ("N", None),
    ]
    for tag, value in sent:
        builder.add_arg(value, tag)
    assert parse_osc(builder.build().dgram) == [("/x", tuple(value for _, value in sent))]


@pytest.mark.parametrize(
    ("why", "datagram"),
    [
        ("unknown type", message("x", bytes(4))),
        ("array never ends", message("[i", bytes(4))),
        ("array never began", message("i]", bytes(4))),
        ("blob of a negative size", message("b", b"\xff" * 4)),
        ("blob longer than the rest", message("b", struct.pack(">i", 5), b"abcd")),
        ("nan", message("f", struct.pack(">f", float("nan")))),
        ("infinite double", message("d", struct.pack(">d", float("inf")))),
        ("no comma", padded("/x") + padded("i") + bytes(4)),
        ("no slash", padded("x") + padded(",")),
        ("string not utf-8", message("s", b"\xff\xfe\0\0")),
        ("address not utf-8", b"/\xff\0\0,\0\0\0"),
        ("too large", message("b", struct.pack(">i", MAX_BYTES), bytes(MAX_BYTES + 1))),
    ],
)
def test_malformed_osc_raises_protocol_error(why: str, datagram: bytes) -> None:
    with pytest.raises(ProtocolError):
        parse_osc(datagram)


def test_a_thousand_nested_bundles_are_refused_quickly() -> None:
    nested = message("")
    for _ in range(1000):
        nested = bundle(IMMEDIATELY, nested)
    with pytest.raises(ProtocolError, match="deep"):
        parse_osc(nested)


def test_a_message_without_tags_has_no_arguments() -> None:
    assert parse_osc(padded("/x")) == [("/x", ())]
