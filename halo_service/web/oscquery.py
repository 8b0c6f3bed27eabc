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
from halo_protocol.table import ROWS, Row
from halo_service.outputs.formats.flat import SLOTS, VALUES, FlatFormat
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame

UNITS = {"_mm_s": "mm/s", "_per_s": "1/s", "_mm": "distance.mm", "_ms": "time.ms", "_g": "gram"}
"""Units by the end of a field's name, the longest end first."""
FLAT_RANGES: dict[str, dict[str, Any]] = {
    "u": {"MIN": 0.0, "MAX": 1.0},
    "v": {"MIN": 0.0, "MAX": 1.0},
    "hover": {"MIN": -1.0},
    "pressure": {"MIN": 0.0},
    "touch": {"VALS": [0, 1]},
}
FLAT_UNITS = {"hover": "distance.mm", "vx": "mm/s", "vy": "mm/s", "strike": "mm/s"}
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
    """Return the unit that the name of a field ends with."""
    return next((unit for end, unit in UNITS.items() if name.endswith(end)), None)


def host_info(node: str, control_port: int) -> dict[str, Any]:
    """Return what `?HOST_INFO` answers: where messages to the service go."""
    return {
        "NAME": f"halo {node}",
        "EXTENSIONS": dict.fromkeys(ATTRIBUTES, True),
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
    reports = {
        address: arguments
        for each in latest
        if not isinstance(each, OutgoingFrame)
        for address, arguments in wire.parse_osc(each.datagrams[0])
    }
    for surface in sorted({each.surface for each in latest}):
        for row in ROWS:
            path = wire.address(surface, row.kind)
            if not row.open_list:
                yield _row_node(row, path, reports.get(path))
        frames = [e for e in latest if isinstance(e, OutgoingFrame) and e.surface == surface]
        yield from _flat_nodes(surface, frames)


def _row_node(row: Row, path: str, value: tuple[wire.Argument, ...] | None) -> Node:
    units = [unit_of(field.name) for field in row.fields for _ in range(field.length or 0)]
    return Node(path, row.tags, Access.READ, f"Sent {row.when}.", value, (), tuple(units))


def _flat_nodes(surface: str, frames: Sequence[OutgoingFrame]) -> Iterator[Node]:
    """Yield the addresses of the format `flat`, with the values of the frame."""
    values = {
        address: arguments
        for frame in frames
        for datagram in FlatFormat().frame(frame)
        for address, arguments in wire.parse_osc(datagram)
    }
    path = wire.address(surface, "count")
    yield Node(path, "i", Access.READ, "Format flat: number of fingers.", values.get(path))
    for slot in range(SLOTS):
        for name, tag in VALUES:
            path = wire.address(surface, f"slot/{slot}/{name}")
            yield Node(
                path,
                tag,
                Access.READ,
                f"Format flat: {name} of the finger in slot {slot}.",
                values.get(path),
                (FLAT_RANGES.get(name),),
                (FLAT_UNITS.get(name) or unit_of(name),),
            )
