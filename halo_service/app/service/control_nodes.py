"""The control addresses for OSCQuery, with ranges and descriptions from the settings' schema.

Rule: pure.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from typing import Any

import halo_protocol as wire
from halo_protocol.handshake import (
    CONTROL,
    EXPIRED,
    GOODBYE,
    HELLO,
    LEASE,
    LEAST_HELLO,
    WELCOME,
)
from halo_service.app.service.commands import STATUS
from halo_service.sensing import SensingSettings
from halo_service.settings.schema import schema_text
from halo_service.web.oscquery import Access, Node, unit_of

LIMIT_G = 2000.0
"""Largest force of the virtual finger."""

ACTIONS = {
    "pause": "Sends frames without pointers until resume.",
    "resume": "Ends a pause.",
    "background": "Measures the background again; keep hands away for two seconds.",
}
OUTCOMES = {"VALS": ["accepted", "warned", "refused"]}
PORT = {"MIN": 0, "MAX": 65_535}
STREAM_REQUESTS = (
    Node(
        HELLO, "ssis", Access.WRITE,
        "Asks for the stream: version, stream such as frames or flat,rate=30, port (0: the "
        f"sender's), padding to {LEAST_HELLO} bytes.",
        None, (None, None, PORT, None),
    ),
    Node(
        WELCOME, "ssssssi", Access.READ,
        "Answers a hello: node, session, version, outcome, token, reason of a refusal, lease.",
        None, (None, None, None, OUTCOMES, None, None, {"MIN": 0}), (*[None] * 6, "time.ms"),
    ),
    Node(LEASE, "s", Access.WRITE, "Starts and continues the stream; send it every 3 s."),
    Node(EXPIRED, "s", Access.READ, "The token of a lease is unknown: say hello again."),
    Node(GOODBYE, "s", Access.WRITE, "Ends the stream of a token."),
)  # fmt: skip
"""How a client asks for the stream."""
FINGER = Node(
    "/halo/1/sim/finger", "iiffff", Access.WRITE,
    "Moves the finger of the virtual camera sim:hand: hand, finger, place, height (below 0: away), "
    "force.",
    None,
    ({"VALS": [1, 2]}, {"VALS": [0, 1, 2, 3, 4]}, None, None, None, {"MIN": 0, "MAX": LIMIT_G}),
    (None, None, "distance.mm", "distance.mm", "distance.mm", "gram"),
)  # fmt: skip
ABOUT_STATUS = (
    "Answers with node, session, version, profile, the last command's error and whether paused."
)


def control_nodes(
    settings: SensingSettings, profile: str, status: tuple[wire.Argument, ...], *, virtual: bool
) -> Iterator[Node]:
    """Yield what clients can send and the answers, with the current values.

    `status`: the arguments of its answer; `virtual`: whether messages can move a finger.
    """
    yield from STREAM_REQUESTS
    for name, description in ACTIONS.items():
        yield Node(CONTROL + name, "N", Access.WRITE, description)
    paused = (*[None] * 5, {"VALS": [0, 1]})
    yield Node(STATUS, "sssssi", Access.BOTH, ABOUT_STATUS, status, paused)
    yield Node(f"{CONTROL}profile", "s", Access.BOTH, "Name of the profile in use.", (profile,))
    for name, value in asdict(settings).items():
        yield _setting(name, value)
    if virtual:
        yield FINGER


def _setting(name: str, value: float | str) -> Node:
    schema = _schema()[name]
    limits = {
        key: limit
        for key, limit in (
            ("MIN", schema.get("minimum", schema.get("exclusiveMinimum"))),
            ("MAX", schema.get("maximum")),
            ("VALS", schema.get("enum")),
        )
        if limit is not None
    }
    return Node(
        f"{CONTROL}sensing/{name}",
        "s" if isinstance(value, str) else "f",
        Access.BOTH,
        schema["description"],
        (value,),
        (limits or None,),
        (unit_of(name),),
    )


@cache
def _schema() -> dict[str, Any]:
    properties: dict[str, Any] = json.loads(schema_text())["$defs"]["SensingSettings"]["properties"]
    return properties
