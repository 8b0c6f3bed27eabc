"""Frames and reports as JSON text, under the names of the wire."""

from __future__ import annotations

import json
from typing import Any

import halo_protocol as wire
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame


def json_text(outgoing: Outgoing) -> str:
    """Return one line of JSON with the message's `kind` and `surface`.

    A frame has its header's fields, `time_us`, `pointers` and `events`; an event comes in three
    frames with the same `contacts`, as on the wire.
    """
    view = _frame(outgoing) if isinstance(outgoing, OutgoingFrame) else _message(outgoing.message)
    view = {"kind": outgoing.kind, "surface": outgoing.surface, **view}
    return json.dumps(view, separators=(",", ":"), allow_nan=False)


def _message(message: wire.Message) -> dict[str, Any]:
    return wire.to_json(message)


def _frame(frame: OutgoingFrame) -> dict[str, Any]:
    return {
        **_message(frame.header),
        "time_us": frame.header.time_us,
        "pointers": [_message(each) for each in frame.pointers],
        "events": [
            *({"kind": "down", **_message(each)} for each in frame.downs),
            *({"kind": "up", **_message(each)} for each in frame.ups),
        ],
    }
