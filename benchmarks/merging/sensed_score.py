"""Compares a canvas that merged real sensing with the truth of its virtual installation."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from halo_service.values import Pointer, TouchFrame
from halo_service.virtual.installation.places import seams_mm
from halo_service.virtual.sim_url import SimRequest

from .sensed import START_US, Down

Line = dict[str, Any]
EARLY_S, LATE_S, NEAR_MM = 0.1, 0.15, 40.0
"""Greatest distance in time and place of a down from its touch."""
AROUND_S = 0.15
"""An id is compared at this time before and after a crossing."""
OVERLAP_MM = 30.0
"""Half of the overlap of two areas."""


@dataclass(slots=True)
class Score:
    """Counts and errors of a run."""

    touches: int = 0
    lost_by_all: int = 0
    """No node reported the touch."""
    lost: int = 0
    """A node reported it, and the canvas did not."""
    again: int = 0
    """Further downs during a touch that one camera reports several times too."""
    again_by_canvas: int = 0
    """Further downs during a touch that each camera reports once at most."""
    wrong_downs: int = 0
    """Downs where nothing touches."""
    crossings: int = 0
    touching: int = 0
    """Crossings while the finger touches."""
    unseen: int = 0
    """No pointer before or after the crossing."""
    changed: int = 0
    """Another id after the crossing."""
    off_mm: list[float] = field(default_factory=list)
    step_mm: list[float] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    def rows(self) -> Iterator[tuple[str, str]]:
        """Yield (name, figure)."""
        yield "touches", f"{self.touches}"
        yield "lost by every node", f"{self.lost_by_all}"
        yield "lost by the canvas alone", f"{self.lost}"
        yield "downs again, by the canvas alone", f"{self.again_by_canvas}"
        yield "downs again, as one camera reports them", f"{self.again}"
        yield "downs where nothing touches", f"{self.wrong_downs}"
        yield "crossings of a seam", f"{self.crossings}"
        yield "of these while touching", f"{self.touching}"
        yield "no pointer before or after", f"{self.unseen}"
        seen = max(self.crossings - self.unseen, 1)
        yield "ids kept, of those with a pointer", f"{1.0 - self.changed / seen:.1%}"
        for name, errors in (("seam error", self.off_mm), ("step at a seam", self.step_mm)):
            middle, most, worst = np.percentile(errors or [math.nan], (50, 95, 99))
            yield f"{name}, mm: median, 95 %, 99 %", f"{middle:.1f} {most:.1f} {worst:.1f}"


def score(
    truth: Sequence[Line],
    frames: Sequence[TouchFrame],
    found: Sequence[Sequence[Down]],
    request: SimRequest,
) -> Score:
    """Compare. `found`: the downs of each node."""
    result = Score()
    fingers = _by_hand(truth)
    touches = [line["contact"] for line in truth if "contact" in line]
    crossings = [
        (hand, t_s)
        for hand, track in fingers.items()
        for t_s in _crossing_times(track, seams_mm(request.room.installation))
    ]
    _score_downs(result, touches, frames, found, fingers)
    _score_crossings(result, crossings, frames, fingers)
    _score_places(result, frames, fingers, seams_mm(request.room.installation))
    return result


Track = tuple[np.ndarray, np.ndarray]
"""(N,) times in s; (N, 3) x, y and whether it touches."""


def _by_hand(truth: Sequence[Line]) -> dict[str, Track]:
    """Return where each hand's index finger is, while it is over the canvas."""
    places: dict[str, list[tuple[float, float, float, float]]] = {}
    for line in truth:
        for finger in line.get("fingers", ()):
            if finger["finger"] == "index":
                row = (line["time_us"] / 1e6, finger["x_mm"], finger["y_mm"], finger["touching"])
                places.setdefault(finger["hand"], []).append(row)
    return {hand: (np.array(rows)[:, 0], np.array(rows)[:, 1:]) for hand, rows in places.items()}


def _crossing_times(
    track: Track, seams: tuple[tuple[float, ...], tuple[float, ...]]
) -> Iterator[float]:
    times, places = track
    for axis, lines in enumerate(seams):
        for seam in lines:
            side = places[:, axis] > seam
            for index in np.flatnonzero(side[1:] != side[:-1]).tolist():
                if times[index + 1] - times[index] < 0.1:
                    yield float(times[index])


def _score_downs(
    result: Score,
    touches: Sequence[Line],
    frames: Sequence[TouchFrame],
    found: Sequence[Sequence[Down]],
    fingers: dict[str, Track],
) -> None:
    sent = [
        (_seconds(frame) - event.ago_ms / 1e3, event.x_mm, event.y_mm)
        for frame in frames
        for event in frame.events
        if event.kind == "down"
    ]
    result.touches = len(touches)
    for touch in touches:
        if (down := _of(touch, sent)) is not None:
            sent.remove(down)
            continue
        by_node = any(_of(touch, downs) is not None for downs in found)
        result.lost += by_node
        result.lost_by_all += not by_node
        who = "the canvas alone" if by_node else "every node"
        result.wrong.append(f"{touch['from_us'] / 1e6:.2f} s: a touch is lost by {who}, {touch}")
    for t_s, x, y in sent:
        if not any(_touches(track, t_s, x, y) for track in fingers.values()):
            result.wrong_downs += 1
            what = "where nothing touches"
        elif any(_repeats(touch, t_s, downs, fingers) for touch in touches for downs in found):
            result.again += 1
            what = "again, as one camera reports it"
        else:
            result.again_by_canvas += 1
            what = "again, by the canvas alone"
        result.wrong.append(f"{t_s:.2f} s: a down at {x:.0f}, {y:.0f} {what}")


def _repeats(touch: Line, t_s: float, downs: Sequence[Down], fingers: dict[str, Track]) -> bool:
    """Whether a touch lasts at a time, and one camera reports it several times."""
    begin_s, end_s = touch["from_us"] / 1e6 - EARLY_S, touch["to_us"] / 1e6 + LATE_S
    track = fingers[touch["hand"]]
    mine = [down for down in downs if begin_s <= down[0] <= end_s and _touches(track, *down)]
    return begin_s <= t_s <= end_s and len(mine) > 1


def _of(touch: Line, downs: Sequence[Down]) -> Down | None:
    """Return the down that is nearest to a touch's beginning."""
    t_s, place = touch["from_us"] / 1e6, (touch["x_mm"], touch["y_mm"])
    near = [
        down
        for down in downs
        if -EARLY_S <= down[0] - t_s <= LATE_S and math.dist(down[1:], place) <= NEAR_MM
    ]
    return min(near, key=lambda down: abs(down[0] - t_s), default=None)


def _touches(track: Track, t_s: float, x: float, y: float) -> bool:
    """Whether a finger touches near there, about then."""
    times, places = track
    near = places[bisect_left(times, t_s - EARLY_S) : bisect_left(times, t_s + EARLY_S)]
    return bool(np.any((near[:, 2] > 0) & (np.hypot(near[:, 0] - x, near[:, 1] - y) < NEAR_MM)))


def _score_crossings(
    result: Score,
    crossings: Sequence[tuple[str, float]],
    frames: Sequence[TouchFrame],
    fingers: dict[str, Track],
) -> None:
    times = [_seconds(frame) for frame in frames]
    for hand, t_s in crossings:
        places = [_place(fingers[hand], t_s + step) for step in (-AROUND_S, AROUND_S)]
        if any(place is None for place in places):
            continue  # it came or went
        result.crossings += 1
        result.touching += bool(all(place is not None and place[2] > 0 for place in places))
        pair = []
        for place, step in zip(places, (-AROUND_S, AROUND_S), strict=True):
            index = min(bisect_left(times, t_s + step), len(times) - 1)
            assert place is not None
            pair.append(_nearest(frames[index].pointers, place))
        before, after = pair
        if before is None or after is None:
            result.unseen += 1
            result.wrong.append(
                f"{t_s:.2f} s: no pointer {'before' if before is None else 'after'}"
            )
        elif before.id != after.id:
            result.changed += 1
            result.wrong.append(f"{t_s:.2f} s: id {before.id} becomes {after.id}")


def _score_places(
    result: Score,
    frames: Sequence[TouchFrame],
    fingers: dict[str, Track],
    seams: tuple[tuple[float, ...], tuple[float, ...]],
) -> None:
    last: dict[int, tuple[float, float, float]] = {}
    for frame in frames:
        t_s = _seconds(frame)
        for track in fingers.values():
            place = _place(track, t_s)
            if place is None or not _on_seam(place, seams):
                continue
            pointer = _nearest(frame.pointers, place)
            if pointer is None:
                continue
            off = pointer.x_mm - float(place[0]), pointer.y_mm - float(place[1])
            result.off_mm.append(math.hypot(*off))
            if pointer.id in last and t_s - last[pointer.id][2] < 0.1:
                result.step_mm.append(math.dist(off, last[pointer.id][:2]))
            last[pointer.id] = (*off, t_s)


def _on_seam(place: np.ndarray, seams: tuple[tuple[float, ...], tuple[float, ...]]) -> bool:
    return any(abs(place[axis] - seam) < OVERLAP_MM for axis in (0, 1) for seam in seams[axis])


def _place(track: Track, t_s: float) -> np.ndarray | None:
    """Return a finger's x, y and touch at a time; None while it is away."""
    times, places = track
    index = bisect_left(times, t_s)
    if not 0 < index < len(times) or times[index] - times[index - 1] > 0.1:
        return None
    share = (t_s - times[index - 1]) / (times[index] - times[index - 1])
    return np.asarray(places[index - 1] + share * (places[index] - places[index - 1]))


def _nearest(pointers: Sequence[Pointer], place: np.ndarray) -> Pointer | None:
    def away(pointer: Pointer) -> float:
        return math.dist((pointer.x_mm, pointer.y_mm), place[:2])

    near = [pointer for pointer in pointers if away(pointer) < NEAR_MM]
    return min(near, key=away, default=None)


def _seconds(frame: TouchFrame) -> float:
    """Return a frame's time in seconds of the scenario."""
    return (frame.time_us - START_US) / 1e6
