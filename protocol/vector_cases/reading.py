"""Datagrams of other programs and later versions, which every reader must read."""

from __future__ import annotations

import struct

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

_EXTRA_TAGS = "hdtTFNI[ic]rmSb"
_EXTRA = (
    struct.pack(">qdQ", -5, 0.1, 1)
    + ints(5, 65)
    + b"\1\2\3\4\5\6\7\x08"
    + padded("later")
    + ints(3)
    + b"abc\0"
)

READINGS = [
    BytesCase("bare-message", "A message without a bundle.", raw_up()),
    BytesCase(
        "nested-bundles",
        "Bundles in bundles, to the depth that is read.",
        now(raw_up(), now(now(now(raw_up()))), bare(encode(TABLE, SCENE))),
    ),
    BytesCase(
        "strangers-in-between",
        "Unknown addresses are skipped, with any arguments.",
        now(
            message("/1/fader1", "f", floats(float("nan"))),
            message("/halo/2/table/up", "iii", ints(1, 2, 3)),
            message("/halo/1/table/later", "?", ints(0)),
            message("/halo/1/table/up/late", "i", ints(1)),
            message("/halo/1/control/hello", "s", padded("1.0.0")),
            message("/halo/1/sim/finger", "ii", ints(2, 1)),
            padded("/old-sender-without-tags"),
            raw_up(),
        ),
    ),
    BytesCase(
        "appended-arguments",
        "A later minor version appends: arguments after the known ones are ignored.",
        now(raw_up(UP_TAGS + _EXTRA_TAGS, rest=_EXTRA)),
    ),
    BytesCase(
        "appended-unknown-type",
        "The same for arguments of an unknown type.",
        now(raw_up(UP_TAGS + "?", rest=ints(1, 2))),
    ),
    BytesCase(
        "unknown-enumerations",
        "An unknown enumeration number stays a number.",
        now(
            message(
                "/halo/1/table/pointer",
                "iiiiifffffffffif",
                ints(7, 0, 9, 8, 6),
                floats(0.5, 0.25, 150, 50, 0, 1, 0, 0, 1),
                ints(1),
                floats(-1),
            )
        ),
    ),
    BytesCase(
        "two-surfaces",
        "One bundle can contain several surfaces.",
        now(raw_up(), message("/halo/1/wall/alive", "ii", ints(3, 4))),
    ),
    BytesCase("empty-bundle", "A bundle without messages.", now()),
    BytesCase("empty-alive-list", "No tags but the comma.", message("/halo/1/table/alive", "")),
]
