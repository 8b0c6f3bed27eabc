"""`labels`: taps and strokes at the times when real people touched a tablet.

Rule: a label file is `touch_id, event, x, y, epoch_ms` a line, with events `touchdown`,
`touchmove`, `touchend`. Lines may be out of order, touches may never end: that is what real
input looks like. Places are scaled to fit the surface.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from halo_service.errors import UserError
from halo_service.files import read_text
from halo_service.virtual.motion import SHORTEST_S, Segment, Timeline, bump
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenario import Scenario, other
from halo_service.virtual.scenarios.common import pointer

EDGE_MM = 30.0
LEAD_S = 4.0
"""From the scenario's start to the first touch."""
LEAST_S = 0.004
"""The shortest touch that is drawn; a label's clock has steps of about that."""
GAP_S = 4.0
"""Longer pauses are cut to this."""


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """One touch: times in s from the scenario's start, and where it went."""

    from_s: float
    to_s: float
    times: np.ndarray[tuple[int], np.dtype[np.float64]]
    """(N,) s, first and last as above."""
    places_mm: np.ndarray[tuple[int, int], np.dtype[np.float64]]
    """(N, 2) on the surface."""


class Event(NamedTuple):
    """One line of a label file."""

    time_s: float
    """Unix time."""
    kind: str
    """`touchdown`, `touchmove` or `touchend`."""
    x: float
    y: float
    """Points of the tablet; 0, 0 for an end."""


Way = list[Event]
"""The events of one touch, its end last."""


def read(path: Path) -> list[Label]:
    """Touches in order of their beginning. Raises UserError for a file without any."""
    return _fitted(raw_touches(path))


def raw_touches(path: Path) -> list[Way]:
    """Touches in the tablet's own points and time. Raises UserError for a file without any."""
    try:
        lines = read_text(path).splitlines()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UserError(
            f"The label file {path} cannot be read ({reason}); give `labels=FILE`."
        ) from None
    touches: dict[str, Way] = {}
    for line in lines:
        parts = line.strip().split(",")
        if len(parts) == 5:
            number, kind, x, y, ms = parts
            event = Event(float(ms) / 1e3, kind, float(x), float(y))
            touches.setdefault(number, []).append(event)
    # At equal times `touchdown` sorts before `touchmove`, and an end's place (0, 0) counts not.
    ways = [sorted(t, key=lambda e: (e.kind == "touchend", e.time_s)) for t in touches.values()]
    ways = [way for way in ways if any(e.kind == "touchdown" for e in way)]
    if not ways:
        raise UserError(f"{path} holds no touches; its lines are: id,event,x,y,epoch_ms.")
    return sorted(ways, key=lambda way: min(e.time_s for e in way))


def _fitted(ways: list[Way]) -> list[Label]:
    """Scale places to the surface, and start at LEAD_S with no pause longer than GAP_S."""
    places = np.array([(e.x, e.y) for way in ways for e in way if e.kind != "touchend"])
    low, size = places.min(axis=0), np.maximum(np.ptp(places, axis=0), 1.0)
    room = np.array([WIDTH_MM, HEIGHT_MM]) - 2.0 * EDGE_MM
    scale = float((room / size).min())
    margin = (np.array([WIDTH_MM, HEIGHT_MM]) - size * scale) / 2.0
    labels: list[Label] = []
    ended = shift = 0.0
    for way in ways:
        moves = [e for e in way if e.kind != "touchend"]
        begin, end = min(e.time_s for e in way), max(e.time_s for e in way)
        if not labels:
            shift = begin - LEAD_S
        shift += max(0.0, begin - shift - max(ended, LEAD_S) - GAP_S)
        from_s, to_s = begin - shift, max(end - shift, begin - shift + LEAST_S)
        times = np.clip(np.array([e.time_s for e in moves]) - shift, from_s, to_s)
        where = margin + (np.array([(e.x, e.y) for e in moves]) - low) * scale
        labels.append(Label(from_s, to_s, times, where))
        ended = max(ended, to_s)
    return labels


def readable(room: Room) -> Room:
    """The room, when its label file holds touches. Raises UserError otherwise."""
    touches(room)
    return room


def touches(room: Room) -> list[Label]:
    """What the room's label file holds. Raises UserError where there is none."""
    if room.labels is None:
        raise UserError("The scenario `labels` needs a file: sim:labels,labels=FILE.")
    return read(Path(room.labels))


def labels(room: Room, rng: np.random.Generator) -> Scenario:
    """Both index fingers; a touch that neither can reach in time is left out. Ends by itself."""
    mine: list[Label] = []
    others: list[Label] = []
    for label in touches(room):
        for hand in (mine, others):
            if not hand or label.from_s - hand[-1].to_s > SHORTEST_S + 0.01:
                hand.append(label)
                break
    hands = [pointer(room, rng, lambda p: _taps(p, mine))]
    if others:
        hands.append(pointer(room, rng, lambda p: _taps(p, others), other(room.dominant)))
    return Scenario(room, [motion for _, motion in hands])


def _taps(p: Timeline, mine: list[Label]) -> Iterator[Segment]:
    yield from p.hold(2.5)
    x, y = mine[0].places_mm[0]
    yield from p.reach(0.9, x_mm=float(x), y_mm=float(y), height_mm=20.0)
    for label in mine:
        yield from _touch(p, label)
    yield from p.reach(0.3, height_mm=25.0)


def _touch(p: Timeline, label: Label) -> Iterator[Segment]:
    seconds = label.to_s - label.from_s

    def slide(s: float) -> dict[str, float]:
        t = label.from_s + s * seconds
        x, y = (float(np.interp(t, label.times, label.places_mm[:, k])) for k in (0, 1))
        return {"x_mm": x, "y_mm": y}

    yield from p.tap_at(
        label.from_s,
        seconds,
        bump(p.rng.uniform(30.0, 90.0)),
        lift_mm=15.0,
        slide=slide if len(label.times) > 1 else None,
        target_mm=(float(label.places_mm[0, 0]), float(label.places_mm[0, 1])),
        to=slide(0.0),
    )
