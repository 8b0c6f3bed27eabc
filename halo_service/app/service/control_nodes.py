"""The control addresses for OSCQuery, with ranges and descriptions from the settings' schema.

Rule: pure.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from typing import Any

from halo_protocol.handshake import CONTROL
from halo_service.sensing import SensingSettings
from halo_service.settings.schema import schema_text
from halo_service.web.oscquery import Access, Node, unit_of

ACTIONS = {
    "pause": "Sends frames without pointers until resume.",
    "resume": "Ends a pause.",
    "background": "Measures the background again; keep hands away for two seconds.",
}


def control_nodes(settings: SensingSettings, profile: str) -> Iterator[Node]:
    """Yield what clients can send, with the current values."""
    for name, description in ACTIONS.items():
        yield Node(CONTROL + name, "N", Access.WRITE, description)
    yield Node(f"{CONTROL}profile", "s", Access.BOTH, "Name of the profile in use.", (profile,))
    for name, value in asdict(settings).items():
        yield _setting(name, value)


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
