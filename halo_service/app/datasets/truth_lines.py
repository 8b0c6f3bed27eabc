"""Lines of a truth file, from what was measured at each frame. Pure."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from halo_service.files import appearing

Line = dict[str, Any]
Who = tuple[str, str]
"""Hand and finger, as the truth names them."""


@dataclass(frozen=True, slots=True)
class Fingertip:
    """One fingertip in one frame."""

    camera_mm: tuple[float, float, float]
    """In the depth camera's frame."""
    height_mm: float
    touching: bool
    force_g: float = -1.0
    """-1: unknown."""


def frame_lines(frames: Iterable[tuple[int, Mapping[Who, Fingertip]]]) -> Iterator[Line]:
    """Yield a line for each frame, and one for each contact when it has ended."""
    begun: dict[Who, tuple[int, Fingertip, float]] = {}
    last_us = 0
    for time_us, fingers in frames:
        last_us = time_us
        yield {"time_us": time_us, "fingers": [_finger(who, tip) for who, tip in fingers.items()]}
        for who, tip in fingers.items():
            if tip.touching:
                from_us, first, peak_g = begun.get(who, (time_us, tip, -1.0))
                begun[who] = from_us, first, max(peak_g, tip.force_g)
        ended = [who for who in begun if who not in fingers or not fingers[who].touching]
        for who in ended:
            yield contact_line(who, begun.pop(who), time_us)
    for who, contact in begun.items():
        yield contact_line(who, contact, last_us)


def contact_line(who: Who, contact: tuple[int, Fingertip, float], to_us: int) -> Line:
    """Return the line of one contact. No data set holds the speed of a strike."""
    from_us, tip, peak_g = contact
    return {
        "contact": {
            "hand": who[0],
            "finger": who[1],
            "from_us": from_us,
            "to_us": to_us,
            "camera_mm": list(tip.camera_mm),
            "strike_mm_s": 0.0,
            "peak_force_g": peak_g,
        }
    }


def write_lines(lines: Sequence[Line], path: Path) -> None:
    """Write a truth file, complete or not at all. Raises OSError."""
    with appearing(path) as file:
        file.write("".join(json.dumps(line) + "\n" for line in lines).encode())


def _finger(who: Who, tip: Fingertip) -> Line:
    return {
        "hand": who[0],
        "finger": who[1],
        "camera_mm": list(tip.camera_mm),
        "height_mm": tip.height_mm,
        "touching": tip.touching,
        "force_g": tip.force_g,
    }
