"""The fleet as a table and as lines.

Rule: pure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from halo_service.app.fleet.node import Node
from halo_service.evaluation.report.table import Table

HEAD = (
    "node", "surface", "state", "rate, Hz", "latency, ms", "clock, ms", "service", "Zenoh",
    "protocol", "age", "found by",
)  # fmt: skip
LEFT_OUT = ("surface", "service", "found by")
"""Columns for which a narrow terminal has no place."""
LINE = (
    "{}", "{}", "{}", "{} Hz", "latency {} ms", "clock {} ms", "service {}", "zenoh {}",
    "protocol {}", "calibration age {}", "by {}",
)  # fmt: skip
UNITS_S = (("days", 86_400), ("hours", 3600), ("min", 60))


def table_of(nodes: Sequence[Node], *, narrow: bool = False) -> Table:
    """Return a row for each node; those with a warning are marked."""
    shown = [n for n, name in enumerate(HEAD) if not narrow or name not in LEFT_OUT]
    rows = (HEAD, *map(cells, nodes))
    head, *chosen = (tuple(row[n] for n in shown) for row in rows)
    return Table("", head, tuple(chosen))


def cells(node: Node) -> tuple[str, ...]:
    """Return the row of a node; `-`: unknown."""
    return (
        f"! {node.node}" if node.warnings else node.node,
        node.surface or "-",
        node.state,
        _rate(node),
        _number(node.latency_ms, ".1f"),
        _number(node.clock_ms, "+.1f"),
        node.versions.service or "-",
        node.versions.zenoh or "-",
        node.versions.protocol or "-",
        _age(node.calibrated_age_s),
        node.by,
    )


def warnings_of(nodes: Sequence[Node]) -> list[str]:
    """Return a line for each warning, with the names of all nodes that it is about."""
    about: dict[str, list[str]] = {}
    for node in nodes:
        for warning in node.warnings:
            about.setdefault(warning, []).append(node.node)
    return [f"! {', '.join(dict.fromkeys(names))}: {text}" for text, names in about.items()]


def line_of(node: Node) -> str:
    """Return a node as one line."""
    words = (form.format(cell) for form, cell in zip(LINE, cells(node), strict=True))
    return "  ".join((*words, *(f"! {each}" for each in node.warnings)))


def value_of(node: Node) -> dict[str, Any]:
    """Return a node as a JSON value, without the watcher's clock."""
    value = {**asdict(node), **_versions(node), "warnings": list(node.warnings)}
    for name in ("versions", "first_s", "last_s"):
        del value[name]
    return value


def _versions(node: Node) -> dict[str, str]:
    """Return the versions under the names of the protocol."""
    protocol, service, zenoh = node.versions
    return {"version": protocol, "service_version": service, "zenoh_version": zenoh}


def _rate(node: Node) -> str:
    if node.fps is None:
        return "-" if node.rate_hz is None else f"?/{node.rate_hz:g}"
    return f"{node.fps:.1f}" if not node.rate_hz else f"{node.fps:.1f}/{node.rate_hz:g}"


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else f"{value:{form}}"


def _age(age_s: float | None) -> str:
    if age_s is None:
        return "-"
    for unit, length_s in UNITS_S:
        if age_s >= 2 * length_s:
            return f"{age_s / length_s:.0f} {unit}"
    return "1 min"
