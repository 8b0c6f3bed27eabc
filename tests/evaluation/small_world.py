"""A small world for the metrics: the surface is the camera's frame, with taps and their reports.

Times are in frames of 33 333 us; frame 0 is at 1 s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from halo_service.evaluation.metrics.truth import Truth, read_truth
from halo_service.geometry.surface import Surface
from halo_service.values import Diagnostics, Finger, Pointer, Side, Touch, TouchEvent, TouchFrame

FRAME_US = 33_333
SURFACE = Surface("table", 300.0, 200.0, np.eye(4))
AWAY_MM = 30.0
COUNT = 30
_NOTHING = Diagnostics((0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def at(frame: float) -> int:
    """Time of a frame, or between two, us."""
    return 1_000_000 + round(frame * FRAME_US)


def contact(
    begin: float, end: float, x_mm: float = 100.0, y_mm: float = 100.0, **more: Any
) -> dict[str, Any]:
    """The truth's line of one touch; times in frames."""
    line = {
        "hand": "right", "finger": "index", "from_us": at(begin), "to_us": at(end),
        "camera_mm": [x_mm, y_mm, 0.0], "strike_mm_s": 200.0, "peak_force_g": 60.0,
    }  # fmt: skip
    return {"contact": line | more}


def finger(
    x_mm: float = 100.0, y_mm: float = 100.0, height_mm: float = AWAY_MM, **more: Any
) -> dict[str, Any]:
    """One finger of the truth's line of a frame."""
    line = {
        "hand": "right", "finger": "index", "camera_mm": [x_mm, y_mm, -height_mm],
        "height_mm": height_mm, "touching": height_mm == 0.0, "force_g": 0.0,
        "pitch_deg": 45.0, "yaw_deg": 0.0,
    }  # fmt: skip
    return line | more


def truth_frames(
    count: int, fingers: Mapping[int, Sequence[dict[str, Any]]] | None = None
) -> list[dict[str, Any]]:
    """Truth's lines of so many frames; where nothing is given a finger hovers."""
    given = fingers or {}
    return [{"time_us": at(k), "fingers": list(given.get(k, [finger()]))} for k in range(count)]


def pointer(id_: int = 1, x_mm: float = 100.0, y_mm: float = 100.0, **more: Any) -> Pointer:
    """A pointer of the right index finger, 30 mm above."""
    fields = {
        "id": id_, "slot": 0, "side": Side.RIGHT, "finger": Finger.INDEX, "state": Touch.HOVER,
        "x_mm": x_mm, "y_mm": y_mm, "hover_mm": AWAY_MM, "pressure": 0.0, "force_g": 0.0,
        "vx_mm_s": 0.0, "vy_mm_s": 0.0, "confidence": 1.0, "contacts": 0,
        "diagnostics": _NOTHING,
    }  # fmt: skip
    return Pointer(**(fields | more))


def down(id_: int = 1, x_mm: float = 100.0, y_mm: float = 100.0, **more: Any) -> TouchEvent:
    """A finger came down."""
    fields = {"strike_mm_s": 0.0, "ago_ms": 0.0, "contacts": 1} | more
    return TouchEvent("down", id_, 0, x_mm, y_mm, **fields)


def up(id_: int = 1, ago_ms: float = 0.0) -> TouchEvent:
    """A finger left."""
    return TouchEvent("up", id_, 0, 100.0, 100.0, 0.0, ago_ms, 1)


def published_frames(
    count: int,
    events: Mapping[int, Sequence[TouchEvent]] | None = None,
    pointers: Mapping[int, Sequence[Pointer]] | None = None,
) -> list[TouchFrame]:
    """So many published frames; where nothing is given one pointer hovers."""
    happened, there = events or {}, pointers or {}
    return [
        TouchFrame(
            at(k),
            "table",
            300.0,
            200.0,
            tuple(there.get(k, [pointer()])),
            tuple(happened.get(k, ())),
        )
        for k in range(count)
    ]


def truth_of(lines: Sequence[dict[str, Any]]) -> Truth:
    """The truth on this surface."""
    return read_truth(lines, SURFACE)


def everywhere(value: Any, count: int = COUNT) -> dict[int, Any]:
    """The same value in each frame."""
    return dict.fromkeys(range(count), value)
