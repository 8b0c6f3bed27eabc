"""A recorded stream: one line of JSON per frame, with the field names of the wire.

Values that only a developer needs are under `diagnostics`.
"""

from __future__ import annotations

import json
import math
from typing import Any

import halo_protocol as wire
from halo_service.outputs.frame_encoder import event_messages, pointer_message
from halo_service.values import Diagnostics, Pointer, TouchFrame

DIGITS = 4
"""Decimals written: a tenth of a micrometre, far below any measurement error here."""


def frame_line(touch_frame: TouchFrame, node: str, session: str, frame: int) -> str:
    """Write a frame as one line of JSON, line end included."""
    line = {
        "time_us": touch_frame.time_us,
        "node": node,
        "session": session,
        "surface": touch_frame.surface,
        "frame": frame,
        "pointers": [_pointer(pointer, touch_frame) for pointer in touch_frame.pointers],
        "events": _events(touch_frame),
    }
    return json.dumps(_rounded(line), separators=(",", ":"), allow_nan=False) + "\n"


def _pointer(pointer: Pointer, touch_frame: TouchFrame) -> dict[str, Any]:
    view = wire.to_json(pointer_message(pointer, touch_frame))
    return view | {"diagnostics": _diagnostics(pointer.diagnostics)}


def _diagnostics(diagnostics: Diagnostics) -> dict[str, Any]:
    return {name: getattr(diagnostics, name) for name in Diagnostics.__slots__}


def _events(touch_frame: TouchFrame) -> list[dict[str, Any]]:
    downs, ups = event_messages(touch_frame.events, touch_frame)
    return [
        *({"kind": "down"} | wire.to_json(down) for down in downs),
        *({"kind": "up"} | wire.to_json(up) for up in ups),
    ]


def _rounded(value: Any) -> Any:
    """Round numbers, so that files are readable and diffs small; NaN and infinity become null."""
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    return value
