"""One node as it is shown, and what is wrong with it.

Rule: pure.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

LOST_S = 3.0
"""Silence after which a service is lost, as in the protocol."""
PARALLEL_S = 0.5
"""Two sessions of one name in parallel for longer than this are two services."""
ANNOUNCED_S = 25.0
"""The same where one is known by mDNS alone: a killed service stays announced for 20 s."""


class Versions(NamedTuple):
    """Empty where unknown."""

    protocol: str
    service: str
    zenoh: str


UNKNOWN = Versions("", "", "")


@dataclass(frozen=True, slots=True)
class Node:
    """One session of a service on one surface; None where a value is unknown."""

    node: str
    surface: str
    session: str
    state: str
    """`running`; `silent`: connected, without messages; `announced`: by mDNS alone; `gone`."""
    by: str
    """`zenoh`, `mdns` or `both`."""
    first_s: float
    last_s: float
    """When it was seen first and last, by the watcher's clock."""
    address: str = ""
    """Host and port for control messages, where mDNS announces them."""
    rate_hz: float | None = None
    """Nominal frames per second."""
    fps: float | None = None
    """Processed frames per second."""
    latency_ms: float | None = None
    """From frame received to packet sent, median."""
    clock_ms: float | None = None
    """Its clock minus this machine's; too small by the delay of the fastest message."""
    versions: Versions = UNKNOWN
    calibrated_age_s: float | None = None
    camera: str = ""
    profile_fit: str = ""
    collision: bool = False
    """Whether it reports another service with its name."""
    warnings: tuple[str, ...] = ()

    def warned(self, *warnings: str) -> Node:
        """Return it with further warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))


def with_collisions(nodes: Sequence[Node]) -> list[Node]:
    """Warn of running services with one name, and of what a node reports of itself."""
    named: dict[str, list[Node]] = {}
    for each in nodes:
        named.setdefault(each.node, []).append(each)
    return [_with_faults(each, _others(each, named[each.node])) for each in nodes]


def _others(node: Node, named: Sequence[Node]) -> list[str]:
    """Return the sessions of other running services with the node's name."""
    return [each.session for each in named if _are_two(node, each)]


def _are_two(a: Node, b: Node) -> bool:
    if a.session == b.session or "gone" in (a.state, b.state) or not (a.session and b.session):
        return False
    parallel_s = min(a.last_s, b.last_s) - max(a.first_s, b.first_s)
    return parallel_s > (ANNOUNCED_S if "mdns" in (a.by, b.by) else PARALLEL_S)


def _with_faults(node: Node, others: Sequence[str]) -> Node:
    if others:
        sessions = " and ".join(sorted({node.session, *others}))
        rename = "give each its own with --node"
        node = node.warned(f"several services have this name (sessions {sessions}): {rename}")
    elif node.collision and node.state == "running":
        node = node.warned("it reports another service with its name; rename one with --node")
    if node.state == "silent":
        node = node.warned("it is connected, but sends nothing that can be read here")
    if node.camera == "lost":
        node = node.warned("its camera is lost")
    if node.profile_fit in ("moved", "tilted", "hidden", "marker"):
        node = node.warned(f"its profile no longer fits ({node.profile_fit})")
    return node


def with_mismatches(nodes: Sequence[Node], here: Versions) -> list[Node]:
    """Warn where the protocol's minor or Zenoh's version is not what most nodes have.

    `here`: of this program, which decides where two versions are equally frequent.
    """
    live = [here, *(each.versions for each in nodes if each.state != "gone")]
    protocol = _most(_minor(each.protocol) for each in live)
    zenoh = _most(each.zenoh for each in live)
    return [_with_mismatch(each, protocol, zenoh) for each in nodes]


def _with_mismatch(node: Node, protocol: str, zenoh: str) -> Node:
    if node.state == "gone":
        return node
    versions = node.versions
    if versions.protocol and _minor(versions.protocol) != protocol:
        node = node.warned(f"it speaks protocol {versions.protocol}, most others {protocol}")
    if versions.zenoh and versions.zenoh != zenoh:
        node = node.warned(f"it has Zenoh {versions.zenoh}, most others {zenoh}")
    return node


def _most(versions: Iterable[str]) -> str:
    """Return the most frequent one, of equally frequent ones the first."""
    counted = Counter(filter(None, versions))
    return max(counted, key=counted.__getitem__, default="")


def _minor(version: str) -> str:
    """`1.2.3` -> `1.2`."""
    return ".".join(version.split(".")[:2])
