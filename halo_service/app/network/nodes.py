"""What arrives from each node in some seconds: frames, losses, versions, clock, and warnings.

Rule: `receive` waits; all else is pure.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

import halo_protocol as wire
from halo_client import Receiver, ZenohSource
from halo_client.follow import Follow
from halo_client.zenoh_input import ZenohInput
from halo_service.app.doctor import Finding
from halo_service.app.fleet.node import Node
from halo_service.app.fleet.watch import FleetWatch

TURN_S = 0.01
LOSSY, BAD = 0.01, 0.2
"""Share of lost frames to mention, and that breaks the use."""
CLOCK_MS = 50.0
"""Difference of clocks to mention."""
LOSSES = (
    "the network loses packets, a cable does not; over Wi-Fi, udp endpoints keep frames on time "
    "(docs/networks.md)"
)
Key = tuple[str, str]
"""(node, surface)."""


@dataclass(frozen=True, slots=True)
class Received:
    """What arrived."""

    seconds: float
    nodes: tuple[Node, ...]
    counts: Sequence[tuple[Counter[Key], Counter[Key]]] = ()
    """Frames that arrived, and frames that were sent and did not, of each source."""

    def best(self, key: Key) -> tuple[int, int]:
        """Return both numbers of the source from which most arrived."""
        return max(((a[key], m[key]) for a, m in self.counts), default=(0, 0))


def receive(sources: Sequence[ZenohSource], seconds: float) -> Received:
    """Receive frames and reports for some seconds."""
    counts: list[tuple[Counter[Key], Counter[Key]]] = [(Counter(), Counter()) for _ in sources]
    with ExitStack() as stack:
        watch = stack.enter_context(closing(FleetWatch(sources)))
        receivers = [
            stack.enter_context(Receiver(ZenohInput(each), Follow(everything=True)))
            for each in sources
        ]
        until_s = time.monotonic() + seconds
        while time.monotonic() < until_s:
            time.sleep(0.0 if receivers else TURN_S)
            for receiver, count in zip(receivers, counts, strict=True):
                _count(receiver.poll(TURN_S), *count)
        return Received(seconds, tuple(watch.nodes()), counts)


def _count(events: Sequence[wire.Event], frames: Counter[Key], missed: Counter[Key]) -> None:
    for event in events:
        if isinstance(event, wire.TouchFrame):
            frames[event.node, event.surface] += 1
            missed[event.node, event.surface] += event.missed


def findings(received: Received) -> list[Finding]:
    """Return findings of all nodes, one for each warning."""
    found = []
    for node in received.nodes:
        found.append(_node(node, received))
        found += [Finding(f"node {node.node}", False, text) for text in node.warnings]
    return list(dict.fromkeys(found))


def _node(node: Node, received: Received) -> Finding:
    what = f"node {node.node}/{node.surface}" if node.surface else f"node {node.node}"
    key = (node.node, node.surface)
    count, missed = received.best(key)
    if node.state == "announced":
        return Finding(
            what,
            False,
            f"announced by mDNS at {node.address}; no Zenoh connection to it",
            "name its address with --connect, if [zenoh] listen opens it there",
            optional=True,
        )
    if not count:
        remedy = "look at its log; a router's access control may deny 'frame' to this machine"
        return Finding(what, False, "no frames arrive", remedy)
    share = missed / (count + missed)
    state = f"{count / received.seconds:.0f} frames/s, {100.0 * share:.1f} % lost{_facts(node)}"
    if share >= LOSSY:
        remedy = LOSSES
        return Finding(what, False, state, remedy, optional=share < BAD)
    if node.clock_ms is not None and abs(node.clock_ms) > CLOCK_MS:
        remedy = "let both machines follow one time server (NTP); touches have the time of the node"
        return Finding(what, False, state, remedy, optional=True)
    return Finding(what, True, state)


def _facts(node: Node) -> str:
    facts = [
        f"protocol {node.versions.protocol}" if node.versions.protocol else "",
        f"Zenoh {node.versions.zenoh}" if node.versions.zenoh else "",
        f"its clock {round(node.clock_ms):+d} ms" if node.clock_ms is not None else "",
    ]
    return "".join(f", {each}" for each in facts if each)
