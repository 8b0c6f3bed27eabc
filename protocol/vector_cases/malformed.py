"""Malformed datagrams, each with one fault."""

from __future__ import annotations

from halo_protocol import encode
from halo_protocol.osc import padded
from vector_cases.build import (
    TABLE,
    UP_TAGS,
    BytesCase,
    bare,
    floats,
    ints,
    message,
    now,
    raw_up,
)
from vector_cases.writing import SCENE

_UP = "/halo/1/table/up"
_FRAME = "/halo/1/table/frame"
_ALIVE = "/halo/1/table/alive"
_HEADER_TAGS = "ssiiiii"
_PLACE = floats(0.5, 0.25, 4.0)
_SCENE = bare(encode(TABLE, SCENE))


def _header(
    node: str = "desk",
    session: str = "s1",
    frame: int = 1,
    time_s: int = 1,
    time_frac_us: int = 0,
    count: int = 0,
    session_ms: int = 0,
) -> bytes:
    numbers = ints(frame, time_s, time_frac_us, count, session_ms)
    return message(_FRAME, _HEADER_TAGS, padded(node), padded(session), numbers)


MALFORMED = [
    BytesCase(name, description, datagram)
    for name, description, datagram in [
        ("nothing", "An empty datagram.", b""),
        ("three-bytes", "OSC comes in fours.", b"/ab"),
        ("text", "Not OSC at all.", b"hello, is this a table?\0"),
        ("address-without-end", "No zero byte.", b"/halo/1/table/up"),
        ("bundle-without-time", "Cut off after its name.", b"#bundle\0"),
        ("element-of-nothing", "An element has at least four bytes.", now() + ints(0)),
        ("element-of-minus-four", "A negative size.", now() + ints(-4) + raw_up()),
        ("element-too-long", "More bytes than there are.", now() + ints(1 << 30) + raw_up()),
        ("element-not-in-fours", "Seven bytes.", now() + ints(7) + b"/a\0\0,\0\0\0"),
        ("cut-off", "Only a part of the second message.", now(raw_up(), raw_up())[:-8]),
        ("too-deep", "One level more than is read.", now(now(now(now(now(raw_up())))))),
        ("no-tags", "A known message without type tags.", padded(_UP)),
        ("tags-without-comma", "They begin with one.", padded(_UP) + padded(UP_TAGS) + bytes(24)),
        ("int-for-float", "A type that is not the row's.", raw_up("iiiffi")),
        (
            "double-for-float",
            "A type that is not the row's.",
            message(_UP, "iidddi", bytes(8 + 24 + 4)),
        ),
        ("too-few-arguments", "The last is missing.", message(_UP, "iifff", ints(7, 0), _PLACE)),
        (
            "arguments-cut-off",
            "Tags announce more arguments.",
            message(_UP, UP_TAGS, ints(7, 0), _PLACE),
        ),
        ("bytes-too-many", "Bytes after the last argument.", raw_up(rest=ints(1))),
        ("nan", "Not a number.", raw_up(u=float("nan"))),
        ("infinity", "Infinity.", raw_up(u=float("-inf"))),
        (
            "string-without-end",
            "A string without its zero byte.",
            message(_FRAME, _HEADER_TAGS, b"desk"),
        ),
        ("string-not-utf8", "Half a character.", message(_FRAME, _HEADER_TAGS, b"\xc3(\0\0")),
        ("node-with-a-slash", "Would be another Zenoh key.", _header(node="desk/2")),
        ("node-with-a-wildcard", "Would match all keys.", _header(node="**")),
        ("session-of-nothing", "A name has 1 to 32 characters.", _header(session="")),
        ("session-too-long", "A name has 1 to 32 characters.", _header(session="s" * 33)),
        (
            "session-like-a-number",
            "A tool would read 1e205678 as a number.",
            _header(session="1e205678"),
        ),
        ("session-like-hex", "It starts with g to z.", _header(session="ab12")),
        ("surface-in-capitals", "Names are lower case.", message("/halo/1/Table/alive", "")),
        ("surface-of-nothing", "A name has 1 to 32 characters.", message("/halo/1//alive", "")),
        ("surface-reserved", "No pointers here.", message("/halo/1/control/alive", "")),
        ("frame-negative", "The counter uses 0 to 2^24 - 1.", _header(frame=-1)),
        ("frame-too-large", "A float32 does not hold it.", _header(frame=2**24)),
        ("session-time-negative", "It uses 0 to 2^24 - 1.", _header(session_ms=-1)),
        ("session-time-too-large", "A float32 does not hold it.", _header(session_ms=2**24)),
        ("time-negative", "Time begins in 1970.", _header(time_s=-1)),
        ("fraction-too-large", "A million is a second.", _header(time_frac_us=1_000_000)),
        ("count-negative", "A count cannot be negative.", _header(count=-1)),
        ("count-too-large", "At most 64.", _header(count=65)),
        ("id-negative", "Ids grow from 0.", raw_up(id=-7)),
        ("alive-twice", "An id occurs once.", message(_ALIVE, "iii", ints(3, 4, 3))),
        ("alive-too-many", "At most 64.", message(_ALIVE, "i" * 65, ints(*range(65)))),
        ("alive-of-floats", "Ids are ints.", message(_ALIVE, "f", floats(1.0))),
        ("alive-cut-off", "Tags announce more arguments.", message(_ALIVE, "ii", ints(3))),
        (
            "scene-without-size",
            "A client divides by it.",
            _SCENE.replace(floats(300.0, 200.0), floats(300.0, 0.0)),
        ),
        ("scene-version", "major.minor.patch.", _SCENE.replace(b"1.0.0\0", b"1.0-b\0")),
        (
            "scene-zenoh-version",
            "It is shown in terminals.",
            _SCENE.replace(b"1.9.0\0", b"1.9\n0\0"),
        ),
    ]
]
