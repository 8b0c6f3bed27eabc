"""Messages `up` of 1.0, 1.1 and 1.2, where 1.1 appends `spin:f` and 1.2 appends `axis:f3`."""

from __future__ import annotations

import struct
from typing import Any

from halo_protocol.osc import padded

UP = (7, 1, 0.5, 0.25, 12.0, 3)
UP_VIEW = {"id": 7, "slot": 1, "u": 0.5, "v": 0.25, "ago_ms": 12.0, "contacts": 3}
SPIN = -1.0
"""The default of `spin`."""
AXIS = (0.0, 0.0, 1.0)
"""The default of `axis`."""


def up(tags: str, *values: float, more: bytes = b"") -> bytes:
    """A datagram of one message; `tags` are the types of its values."""
    return padded("/halo/1/table/up") + padded(f",{tags}") + struct.pack(f">{tags}", *values) + more


def view(spin: float, axis: tuple[float, ...]) -> dict[str, Any]:
    """What a reader of 1.2 reads, in the JSON view."""
    return {**UP_VIEW, "spin": spin, "axis": list(axis)}


READ = {
    "1.0": (up("iifffi", *UP), view(SPIN, AXIS)),
    "1.1": (up("iifffif", *UP, 2.5), view(2.5, AXIS)),
    "1.2": (up("iifffiffff", *UP, 2.5, 1.0, 2.0, 3.0), view(2.5, (1.0, 2.0, 3.0))),
    "1.3": (up("iifffiffffi", *UP, 2.5, 1.0, 2.0, 3.0, 9), view(2.5, (1.0, 2.0, 3.0))),
}
"""Minor version of the sender -> (datagram, what is read)."""

REFUSED = {
    "a field of 1.0 is missing": (up("iifff", *UP[:5]), ",iifffi, not b',iifff'"),
    "no field": (up(""), ",iifffi, not b','"),
    "half a list": (up("iifffifff", *UP, 2.5, 1.0, 2.0), ",iifffiffff, not b',iifffifff'"),
    "another type": (up("iifffii", *UP, 2), ",iifffiffff, not b',iifffii'"),
    "bytes too many": (up("iifffi", *UP, more=bytes(4)), "4 bytes too many"),
    "bytes are missing": (up("iifffif", *UP, 2.5)[:-4], "needs 28 bytes, has 24"),
}
"""What is wrong -> (datagram, the end of Python's sentence)."""
