"""OSCQuery: what can be sent and received, as JSON that node tools read.

Rule: pure. A node is one address; the tree, the attributes and the host's description follow the
OSCQuery proposal. Current values come from the same encoders as the stream.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import halo_protocol as wire
from halo_protocol import fields
from halo_protocol.table import ROWS, Row
from halo_service.outputs.formats.flat import SLOTS, VALUES, FlatFormat
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame

UNITS = {
    "mm": "distance.mm", "px": "distance.pixels", "s": "time.second", "ms": "time.ms",
    "Hz": "time.hz", "g": "gram",
}  # fmt: skip
"""Our unit -> the proposal's name; others are written as they are."""
TYPICAL = {name: {"MIN": 0.0, "MAX": 1.0} for name in ("u", "v")}
"""Ranges for a slider; values may lie outside."""
FEW = 8
"""A range of so few whole numbers is written as a list of values."""
MANY = ("/pointer", "/down", "/up")
"""Messages that come once for each finger: they have no one current value."""
ATTRIBUTES = ("ACCESS", "VALUE", "RANGE", "DESCRIPTION", "UNIT")
"""Optional attributes that are supported."""


class Access(IntEnum):
    """What can be done with an address, as the proposal numbers it."""

    READ = 1
    WRITE = 2
    BOTH = 3


@dataclass(frozen=True, slots=True)
class Node:
    """One address."""

    path: str
    tags: str
    """OSC types of its arguments; `N` for an action without arguments."""
    access: Access
    description: str
    value: tuple[Any, ...] | None = None
    """Current arguments; None if there are none yet."""
    ranges: tuple[dict[str, Any] | None, ...] = ()
    units: tuple[str | None, ...] = ()

    def attributes(self) -> dict[str, Any]:
        """Return the node as the proposal writes it."""
        attributes: dict[str, Any] = {
            "FULL_PATH": self.path,
            "TYPE": self.tags,
            "ACCESS": int(self.access),
            "DESCRIPTION": self.description,
        }
        if self.value is not None:
            attributes["VALUE"] = list(self.value)
        if any(self.ranges):
            attributes["RANGE"] = list(self.ranges)
        if any(self.units):
            attributes["UNIT"] = list(self.units)
        return attributes


def unit_of(name: str) -> str | None:
    """Return the unit of a field as the proposal writes it; None if it has none."""
    unit = fields.unit_of(name)
    return UNITS.get(unit, unit) or None


def range_of(name: str, tag: str) -> dict[str, Any] | None:
    """Return the range of a field as the proposal writes it; None if it has no limit."""
    if name in TYPICAL:
        return TYPICAL[name]
    first, last = fields.range_of(name)
    if tag == "i" and first is not None and last is not None and last - first < FEW:
        return {"VALS": list(range(int(first), int(last) + 1))}
    limits = {"MIN": first, "MAX": last}
    return {key: limit for key, limit in limits.items() if limit is not None} or None


def host_info(node: str, control_host: str, control_port: int) -> dict[str, Any]:
    """Return what `?HOST_INFO` answers: where messages to the service go.

    `control_host`: the address of the control port; empty: that of this server.
    """
    return {
        "NAME": f"halo {node}",
        "EXTENSIONS": dict.fromkeys(ATTRIBUTES, True),
        **({"OSC_IP": control_host} if control_host else {}),
        "OSC_PORT": control_port,
        "OSC_TRANSPORT": "UDP",
    }


def tree(nodes: Iterable[Node]) -> dict[str, Any]:
    """Return the root of the namespace."""
    root: dict[str, Any] = {"FULL_PATH": "/", "ACCESS": 0, "CONTENTS": {}}
    for node in nodes:
        container, path = root, ""
        *parents, name = node.path.strip("/").split("/")
        for parent in parents:
            path = f"{path}/{parent}"
            empty = {"FULL_PATH": path, "ACCESS": 0, "CONTENTS": {}}
            container = container["CONTENTS"].setdefault(parent, empty)
        container["CONTENTS"][name] = node.attributes()
    return root


def find(root: dict[str, Any], path: str) -> dict[str, Any] | None:
    """Return the container or node at a path; None if there is none."""
    found: dict[str, Any] | None = root
    for part in filter(None, path.split("/")):
        found = (found or {}).get("CONTENTS", {}).get(part)
    return found


def stream_nodes(latest: Sequence[Outgoing]) -> Iterator[Node]:
    """Yield the addresses that the service sends. `latest`: the last frame and reports."""
    values = {
        address: arguments
        for each in latest
        for address, arguments in wire.parse_osc(each.datagrams[0])
        if not address.endswith(MANY)
    }
    for surface in sorted({each.surface for each in latest}):
        for row in ROWS:
            path = wire.address(surface, row.kind)
            yield _row_node(row, path, values.get(path))
        frames = [e for e in latest if isinstance(e, OutgoingFrame) and e.surface == surface]
        yield from _flat_nodes(surface, frames)


def _row_node(row: Row, path: str, value: tuple[wire.Argument, ...] | None) -> Node:
    count = len(value or ())
    fields_ = [each for each in row.fields for _ in range(each.length or count)]
    return Node(
        path,
        "".join(each.tag for each in fields_),
        Access.READ,
        f"Sent {row.when}.",
        value,
        tuple(range_of(each.name, each.tag) for each in fields_),
        tuple(unit_of(each.name) for each in fields_),
    )


def _flat_nodes(surface: str, frames: Sequence[OutgoingFrame]) -> Iterator[Node]:
    """Yield the addresses of the format `flat`, with the values of the frame."""
    values = {
        address: arguments
        for frame in frames
        for datagram in FlatFormat().frame(frame)
        for address, arguments in wire.parse_osc(datagram)
    }
    path = wire.address(surface, "count")
    about = "Format flat: number of fingers."
    yield Node(path, "i", Access.READ, about, values.get(path), (range_of("count", "i"),))
    for slot in range(SLOTS):
        for name, tag in VALUES:
            path = wire.address(surface, f"slot/{slot}/{name}")
            yield Node(
                path,
                tag,
                Access.READ,
                f"Format flat: {name} of the finger in slot {slot}.",
                values.get(path),
                (range_of(name, tag),),
                (unit_of(name),),
            )
