"""What a correct client shows, and how another client's lines differ from it.

Rule: pure. Events of different services may come in any order; those of one session may not.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any

import halo_protocol as wire
from halo_service.app.conformance.script import Step, rules, steps
from halo_service.errors import UserError

Line = dict[str, Any]
Key = tuple[str, str]
"""(node, session); a collision has both sessions."""

KINDS = ("frame", "lost", "collision")
TICK_S = 0.05
"""How often the reference client looks for lost services."""
CLOSE = 1e-5
"""Relative difference of numbers that count as equal: a float32 printed as such."""


def expected() -> list[Line]:
    """The lines of a correct client, in the order of arrival."""
    assembler = wire.Assembler()
    events: list[wire.Event] = []
    now_s = 0.0
    for step in steps():
        while now_s + TICK_S < step.at_s:
            now_s += TICK_S
            events += assembler.expire(now_s)
        now_s = step.at_s
        events += _received(assembler, step)
    return [wire.event_to_json(event) for event in events]


def _received(assembler: wire.Assembler, step: Step) -> list[wire.Event]:
    if step.datagram is None:
        return assembler.expire(step.at_s)
    try:
        return assembler.receive_data(step.datagram, step.at_s)
    except wire.ProtocolError:
        return assembler.expire(step.at_s)


def read_lines(text: str, name: str) -> list[Line]:
    """A client's lines. Raises `UserError` with the first bad one."""
    lines = []
    for number, raw in enumerate(text.splitlines(), 1):
        try:
            line = json.loads(raw)
            if not isinstance(line["kind"], str):
                raise TypeError("kind is no text")
        except (ValueError, TypeError, KeyError) as error:
            raise UserError(
                f"{name}, line {number}: not an object with a 'kind' ({error}); write lines like "
                "those of `halo conformance --expected FILE`"
            ) from error
        lines.append(line)
    return lines


def differences(lines: Iterable[Line]) -> dict[str, str]:
    """Node -> the first difference of its lines; empty if the client is correct."""
    right, found = _by_session(expected()), _by_session(lines)
    wrong: dict[str, str] = {}
    for key in (*right, *(key for key in found if key not in right)):
        difference = _difference(right.get(key, []), found.get(key, []))
        if difference:
            wrong.setdefault(key[0], f"session {key[1]}: {difference}")
    return wrong


def _by_session(lines: Iterable[Line]) -> dict[Key, list[Line]]:
    groups: dict[Key, list[Line]] = {}
    for line in lines:
        if line["kind"] in KINDS:
            session = line.get("session", line.get("sessions"))
            groups.setdefault((str(line.get("node")), str(session)), []).append(line)
    return groups


def _difference(right: list[Line], found: list[Line]) -> str:
    for number, (one, other) in enumerate(zip(right, found, strict=False), 1):
        for name, value in one.items():
            if not _equal(value, other.get(name)):
                where = f"event {number} ({one['kind']} {one.get('frame', '')}".rstrip() + ")"
                return f"{where}: {name} is {_short(other.get(name))}, expected {_short(value)}"
    if len(right) == len(found):
        return ""
    return f"{len(found)} events, expected {len(right)}"


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return isinstance(other, dict) and all(_equal(v, other.get(k)) for k, v in one.items())
    if isinstance(one, list):
        return isinstance(other, list) and len(one) == len(other) and all(map(_equal, one, other))
    if isinstance(one, float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=CLOSE, abs_tol=CLOSE)
    return bool(one == other)


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 160 else f"{text[:160]}..."


def verdict(lines: Iterable[Line]) -> list[tuple[str, str, str]]:
    """(node, its rule, the first difference or "") of each service of the script."""
    wrong = differences(lines)
    known = rules()
    found = [(node, rule, wrong.pop(node, "")) for node, rule in known.items()]
    return [*found, *((node, "no such service", why) for node, why in wrong.items())]
