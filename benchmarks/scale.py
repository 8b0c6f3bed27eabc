"""What many nodes cost at one router: `nice uv run python benchmarks/scale.py`. Linux alone.

Nodes without cameras send frames of two pointers at 30 a second, scenes and healths, by the real
encoder and the real Zenoh output, to `halo router` on the loopback. Their sessions share a few
processes. A subscriber receives from all, from one, the healths of all, or nothing. Two routers:
the nodes are at one, the subscriber at the other. Below is what the model of `scaling/model.py`
predicts for the same rows. Goal: what a node costs is flat, within a half from 10 to 100 nodes.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from scaling.model import HEALTH_HZ, Stream, frames_of, health_bytes, plan, plus, reports_of
from scaling.processes import Role, Router, nodes, subscriber

import halo_protocol as wire

NODES_EACH = 50
"""Nodes of one process."""
SETTLE_S = 2.0
FLAT = 1.5
ALL = "all"
KEYS = {
    ALL: ("halo/1/**",),
    "one": ("halo/1/n000/**",),
    "healths": (wire.zenoh_key(wire.ANY, wire.ANY, "health"),),
    "nothing": (),
}
ROWS = (
    (1, 2, ALL, 1), (10, 2, ALL, 1), (30, 2, ALL, 1), (100, 2, ALL, 1),
    (100, 2, "one", 1), (100, 2, "healths", 1), (100, 2, "nothing", 1),
    (30, 8, ALL, 1), (30, 2, ALL, 2),
)  # fmt: skip
"""Nodes, pointers, what the subscriber gets, routers."""
HEAD = (
    "nodes", "ptr", "reads", "routers", "msg/s", "kB/s in", "kB/s out", "router", "/node",
    "sender", "memory", "median", "p99", "lost", "join", "load",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured with some nodes, a second or a node."""

    nodes: int
    pointers: int
    reads: str
    routers: int
    messages: float
    """That arrived at the subscriber."""
    tcp_in: float
    tcp_out: float
    """Bytes of TCP at the router of the nodes."""
    router_cpu: float
    """Cores."""
    sender_cpu: float
    """Cores of a node."""
    memory_mb: float
    """Of the router."""
    median_ms: float
    p99_ms: float
    lost: float
    """Share of the frames."""
    join_bytes: float
    """Of a node, in both directions, until it sends."""
    load: float


def main() -> int:
    """Print both tables; 1 if a node's cost is not flat."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=10.0, help="for each row")
    parser.add_argument("--rows", type=int, nargs="+", help="numbers of the rows, from 0")
    parser.add_argument("--plan", action="store_true", help="print trees of routers, and end")
    options = parser.parse_args()
    if options.plan:
        print_plans()
        return 0
    print(f"load of the machine before: {os.getloadavg()[0]:.1f}")
    print("  ".join(f"{each:>8}" for each in HEAD))
    chosen = [ROWS[each] for each in options.rows] if options.rows else ROWS
    rows = []
    for each in chosen:
        rows.append(measure(*each, options.seconds))
        print(line(rows[-1]), flush=True)
    print_comparison(rows)
    return int(not is_flat(rows))


def measure(count: int, pointers: int, reads: str, routers: int, seconds: float) -> Row:
    """Measure one row."""
    names = [f"n{number:03}" for number in range(count)]
    with ExitStack() as stack:
        router = stack.enter_context(closing(Router()))
        far = router if routers == 1 else stack.enter_context(closing(Router([router.endpoint])))
        reader = stack.enter_context(closing(Role(subscriber, far.endpoint, KEYS[reads])))
        before = router.bytes
        senders = [
            stack.enter_context(closing(Role(nodes, router.endpoint, part, pointers)))
            for part in parts(names)
        ]
        time.sleep(SETTLE_S)
        join_bytes = float((router.bytes - before)[:2].sum())
        for each in senders:
            each.start()
        time.sleep(SETTLE_S)
        first = snapshot(router, senders, reader, "begin")
        time.sleep(seconds)
        last = snapshot(router, senders, reader, "end")
    return row(count, pointers, reads, routers, first, last, join_bytes)


def parts(names: Sequence[str]) -> list[list[str]]:
    """Return the names of each process."""
    remaining = iter(names)
    return list(iter(lambda: list(islice(remaining, NODES_EACH)), []))


@dataclass(frozen=True, slots=True)
class Snapshot:
    """All counters at a moment."""

    at_s: float
    tcp: np.ndarray
    router_cpu_s: float
    memory_mb: float
    sender_cpu_s: float
    got: dict[str, Any] | None


def snapshot(router: Router, senders: Sequence[Role], reader: Role, request: str) -> Snapshot:
    """Read all counters."""
    usage, cpu_s = router.usage, sum(each.usage.cpu_s for each in senders)
    at_s, tcp = time.monotonic(), router.bytes
    return Snapshot(at_s, tcp, usage.cpu_s, usage.memory_mb, cpu_s, reader.ask(request))


def row(
    count: int,
    pointers: int,
    reads: str,
    routers: int,
    first: Snapshot,
    last: Snapshot,
    join_bytes: float,
) -> Row:
    """Return what changed between two moments, a second."""
    seconds = last.at_s - first.at_s
    got = last.got
    assert got is not None
    tcp = (last.tcp - first.tcp) / seconds
    return Row(
        count,
        pointers,
        reads,
        routers,
        got["messages"] / seconds,
        tcp[0],
        tcp[1],
        (last.router_cpu_s - first.router_cpu_s) / seconds,
        (last.sender_cpu_s - first.sender_cpu_s) / seconds / count,
        last.memory_mb,
        float(np.median(got["late_ms"])),
        float(np.percentile(got["late_ms"], 99)),
        got["lost"] / max(got["frames"] + got["lost"], 1),
        join_bytes / count,
        os.getloadavg()[0],
    )


def line(each: Row) -> str:
    """Return a row as text."""
    cells = (
        f"{each.nodes}", f"{each.pointers}", each.reads, f"{each.routers}",
        f"{each.messages:.0f}", f"{each.tcp_in / 1e3:.1f}", f"{each.tcp_out / 1e3:.1f}",
        f"{each.router_cpu:.1%}", f"{each.router_cpu / each.nodes:.2%}", f"{each.sender_cpu:.2%}",
        f"{each.memory_mb:.0f} MB", *map(milliseconds, (each.median_ms, each.p99_ms)),
        f"{each.lost:.2%}", f"{each.join_bytes / 1e3:.1f} kB", f"{each.load:.1f}",
    )  # fmt: skip
    return "  ".join(f"{cell:>8}" for cell in cells)


def milliseconds(value: float) -> str:
    """Return it as text; `-` where no frame was read."""
    return "-" if np.isnan(value) else f"{value:.2f} ms"


def predicted(each: Row) -> tuple[float, float, float]:
    """Return messages that arrive, bytes that come to the router and bytes that leave it."""
    frames, reports = frames_of(each.pointers), reports_of()
    everything = plus(frames, reports)
    health = Stream(HEALTH_HZ, HEALTH_HZ * health_bytes("n000", "s1", "table"))
    read = {
        ALL: everything.times(each.nodes),
        "one": everything,
        "healths": health.times(each.nodes),
        "nothing": Stream(0.0, 0.0),
    }[each.reads]
    return read.messages, read.to_router(), read.from_router()


def print_comparison(rows: Sequence[Row]) -> None:
    """Print what the model predicts, and what was measured."""
    print("\npredicted / measured")
    print(
        f"{'nodes':>8}{'reads':>10}{'routers':>9}{'messages/s':>18}{'kB/s in':>20}{'kB/s out':>20}"
    )
    for each in rows:
        messages, tcp_in, tcp_out = predicted(each)
        print(
            f"{each.nodes:8}{each.reads:>10}{each.routers:9}"
            f"{messages:9.0f} /{each.messages:7.0f}"
            f"{tcp_in / 1e3:11.1f} /{each.tcp_in / 1e3:7.1f}"
            f"{tcp_out / 1e3:11.1f} /{each.tcp_out / 1e3:7.1f}"
        )


def print_plans() -> None:
    """Print what passes the routers of a tree."""
    for surfaces in (10, 100, 10_000):
        found = plan(surfaces)
        print(
            f"{surfaces} surfaces: {found.routers} routers, watcher {found.watched:.0f} messages/s"
        )
        for name, load in (("leaf", found.leaf), ("root", found.root)):
            if load is not None:
                print(
                    f"  {name}: {load.links:.0f} links, {load.messages:.0f} messages/s, "
                    f"{load.wire * 8 / 1e6:.1f} Mbit/s, {load.cores:.2f} cores"
                )


def is_flat(rows: Sequence[Row]) -> bool:
    """Whether a node of 100 costs no more than one of 10, of router and sender."""
    costs = {
        each.nodes: (each.router_cpu / each.nodes, each.sender_cpu)
        for each in rows
        if each.reads == ALL and each.routers == 1 and each.pointers == 2
    }
    if not {10, 100} <= costs.keys():
        return True
    return all(many <= FLAT * few for few, many in zip(costs[10], costs[100], strict=True))


if __name__ == "__main__":
    sys.exit(main())
