"""Units and ranges of the fields, by their names: a name means the same in every message.

Rule: for the specification, for OSCQuery and for programs that show values. A reader checks only
what `checks` lists: a later minor version may allow more.
"""

from __future__ import annotations

from typing import NamedTuple

from halo_protocol.checks import MAX_POINTERS
from halo_protocol.counter import MODULUS
from halo_protocol.jsonview import ENUMERATIONS


class Range(NamedTuple):
    """The smallest and the largest value; None if there is no limit."""

    first: float | None
    last: float | None = None


_LARGEST_INT = 2**31 - 1
_FROM_0 = Range(0)
_SWITCH = Range(0, 1)

_UNITS = {
    "_mm_s": "mm/s", "_per_s": "1/s", "_mm": "mm", "_ms": "ms", "_frac_us": "us", "_g": "g",
    "_px": "px", "_hz": "Hz", "_s": "s",
}  # fmt: skip
"""By the end of a name, the longest end first."""
_UNIT_OF = {
    "fps": "Hz", "camera_from_surface": "mm", "anchor_from_surface": "mm",
    "projector_from_surface": "mm -> px", "hover": "mm", "vx": "mm/s", "vy": "mm/s",
    "strike": "mm/s",
}  # fmt: skip
"""Of names without a unit."""

_RANGES: dict[str, Range] = {
    "frame": Range(0, MODULUS - 1),
    "time_s": Range(0, _LARGEST_INT),
    "time_frac_us": Range(0, 999_999),
    "count": Range(0, MAX_POINTERS),
    "session_ms": Range(0, MODULUS - 1),
    "hover_mm": _FROM_0,
    "pressure": _FROM_0,
    "confidence": Range(0, 1),
    "force_g": Range(-1),
    "strike_mm_s": Range(-1),
    "ago_ms": _FROM_0,
    "width_mm": _FROM_0,
    "height_mm": _FROM_0,
    "rate_hz": _FROM_0,
    "control_port": Range(0, 65_535),
    "collision": _SWITCH,
    "calibrated_s": Range(0, _LARGEST_INT),
    "width_px": Range(1, _LARGEST_INT),
    "height_px": Range(1, _LARGEST_INT),
    "anchored": _SWITCH,
    "fps": _FROM_0,
    "latency_ms": Range(-1),
    "tracker_ms": Range(-1),
    **dict.fromkeys(
        ("id", "ids", "slot", "contacts", "revision", "drops", "bad_frames", "clock_jumps"),
        Range(0, _LARGEST_INT),
    ),
    **{
        name: Range(min(members), max(members)) for name, members in ENUMERATIONS.items()
    },  # a later minor version may append values
    # The format `flat`:
    "hover": Range(-1),
    "touch": _SWITCH,
    "strike": Range(-1),
}


def unit_of(name: str) -> str:
    """Return the unit of a field; empty if it has none."""
    if name in _UNIT_OF:
        return _UNIT_OF[name]
    return next((unit for end, unit in _UNITS.items() if name.endswith(end)), "")


def range_of(name: str) -> Range:
    """Return the range of a field."""
    return _RANGES.get(name, Range(None))
