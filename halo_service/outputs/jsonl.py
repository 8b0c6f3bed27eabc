"""A recorded stream: one line of JSON a frame, under the wire's names.

What only a developer wants stands under `diagnostics`.
"""

from __future__ import annotations

import json
import math
from typing import Any

import halo_protocol as wire
from halo_service.outputs.wire import event_messages, pointer_message
from halo_service.values import Diagnostics, Pointer, TouchFrame

DIGITS = 4
"""Decimals kept: a tenth of a micrometre, far below what anything here measures."""


def frame_line(told: TouchFrame, node: str, session: str, frame: int) -> str:
    """Write a frame as one line of JSON, line end included."""
    line = {
        "time_us": told.time_us,
        "node": node,
        "session": session,
        "surface": told.surface,
        "frame": frame,
        "pointers": [_pointer(pointer, told) for pointer in told.pointers],
        "events": _events(told),
    }
    return json.dumps(_rounded(line), separators=(",", ":"), allow_nan=False) + "\n"


def _pointer(pointer: Pointer, told: TouchFrame) -> dict[str, Any]:
    view = wire.to_json(pointer_message(pointer, told))
    return view | {"diagnostics": _diagnostics(pointer.diagnostics)}


def _diagnostics(known: Diagnostics) -> dict[str, Any]:
    return {name: getattr(known, name) for name in Diagnostics.__slots__}


def _events(told: TouchFrame) -> list[dict[str, Any]]:
    downs, ups = event_messages(told.events, told)
    return [
        *({"kind": "down"} | wire.to_json(down) for down in downs),
        *({"kind": "up"} | wire.to_json(up) for up in ups),
    ]


def _rounded(value: Any) -> Any:
    """Round numbers for the eye and the diff; what is not a number becomes null."""
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    return value
