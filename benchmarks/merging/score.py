"""Compares what a canvas sent with the truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from halo_service.values import Pointer, TouchFrame

from .truth import Finger, Truth

MATCH_S, MATCH_MM = 0.12, 45.0
"""Greatest distance in time and place of a down from its finger."""
SEAM_MM = 40.0
"""Places nearer to a seam count for the seam error."""


@dataclass(slots=True)
class Score:
    """Counts and errors of a run."""

    crossings: int = 0
    true_downs: int = 0
    doubled: int = 0
    lost: int = 0
    kept: int = 0
    """Crossings with one id from before to behind the seam."""
    late_ms: list[float] = field(default_factory=list)
    off_mm: list[float] = field(default_factory=list)
    step_mm: list[float] = field(default_factory=list)
    """How much more a pointer moved from frame to frame than its finger, at a seam."""
    frames: int = 0
    duration_s: float = 0.0
    wrong: list[str] = field(default_factory=list)
    """What went wrong, a sentence each."""

    def rows(self) -> list[tuple[str, str, str, bool]]:
        """Return (name, figure, goal, met)."""
        median_ms, p99_ms = np.percentile(self.late_ms, (50, 99))
        off_mm = np.percentile(self.off_mm, (50, 95, 99))
        step_mm = np.percentile(self.step_mm, (50, 99, 100))
        kept = self.kept / max(self.crossings, 1)
        return [
            ("crossings", f"{self.crossings}", "", True),
            ("frames a second", f"{self.frames / self.duration_s:.1f}", "", True),
            ("added latency, median", f"{median_ms:.1f} ms", "<= 33.3 ms", median_ms <= 33.3),
            ("added latency, 99 %", f"{p99_ms:.1f} ms", "", True),
            ("seam error, median", f"{off_mm[0]:.1f} mm", "", True),
            ("seam error, 95 %", f"{off_mm[1]:.1f} mm", "<= 5 mm", bool(off_mm[1] <= 5.0)),
            ("seam error, 99 %", f"{off_mm[2]:.1f} mm", "", True),
            ("step from frame to frame, 99 %", f"{step_mm[1]:.1f} mm", "", True),
            ("step from frame to frame, most", f"{step_mm[2]:.1f} mm", "", True),
            ("downs", f"{self.true_downs}", "", True),
            ("doubled downs", f"{self.doubled}", "0", self.doubled == 0),
            ("lost downs", f"{self.lost}", "0", self.lost == 0),
            ("ids kept", f"{kept:.1%}", ">= 99 %", kept >= 0.99),
        ]


def score(
    truth: Truth, frames: Sequence[TouchFrame], start_us: int, seams_mm: Sequence[float]
) -> Score:
    """Compare; `start_us`: the canvas's time at which the truth begins."""
    result = Score(frames=len(frames), duration_s=truth.end_s)
    result.crossings = sum(finger.crosses for finger in truth.fingers)
    _score_downs(result, truth, frames, start_us)
    tracks: dict[int, list[tuple[float, Pointer]]] = {n: [] for n in range(len(truth.fingers))}
    for frame in frames:
        t_s = (frame.time_us - start_us) / 1e6
        there = dict(truth.at(t_s))
        for number, pointer in _matched(there, frame.pointers, t_s).items():
            tracks[number].append((t_s, pointer))
    for number, finger in enumerate(truth.fingers):
        _score_track(result, number, finger, tracks[number], seams_mm)
    return result


def _score_downs(result: Score, truth: Truth, frames: Sequence[TouchFrame], start_us: int) -> None:
    """Match each true down with one of the canvas."""
    true = [
        (down, *f.place_mm(down), n) for n, f in enumerate(truth.fingers) for down, _ in f.touches
    ]
    sent = [
        ((frame.time_us - start_us) / 1e6 - event.ago_ms / 1e3, event.x_mm, event.y_mm, event.id)
        for frame in frames
        for event in frame.events
        if event.kind == "down"
    ]
    result.true_downs = len(true)
    left = sorted(sent)
    for down in sorted(true):
        near = [
            each
            for each in left
            if -MATCH_S / 2 <= each[0] - down[0] <= MATCH_S
            and math.dist(each[1:3], down[1:3]) <= MATCH_MM
        ]
        if near:
            left.remove(min(near, key=lambda each: math.dist(each[1:3], down[1:3])))
        else:
            result.lost += 1
            result.wrong.append(f"{down[0]:.3f} s: the down of finger {down[3]} is lost")
    result.doubled = len(left)
    result.wrong += [
        f"{t:.3f} s: a down of pointer {id_} too much at {x:.0f}, {y:.0f}" for t, x, y, id_ in left
    ]


def _matched(
    there: dict[int, Finger], pointers: Sequence[Pointer], t_s: float
) -> dict[int, Pointer]:
    """Return the pointer of each finger: the assignment with the smallest distances."""
    places = [finger.place_mm(t_s) for finger in there.values()]
    away = np.array([[math.dist(xy, (p.x_mm, p.y_mm)) for p in pointers] for xy in places])
    if not away.size:
        return {}
    numbers = list(there)
    return {
        numbers[i]: pointers[j]
        for i, j in zip(*linear_sum_assignment(away), strict=True)
        if away[i, j] < MATCH_MM
    }


def _score_track(
    result: Score,
    number: int,
    finger: Finger,
    track: Sequence[tuple[float, Pointer]],
    seams_mm: Sequence[float],
) -> None:
    """Note its errors at the seam, and whether its id was kept."""
    before: tuple[float, float, float, float] | None = None
    ids = [pointer.id for _, pointer in track]
    for t_s, pointer in track:
        x, y = finger.place_mm(t_s)
        off = pointer.x_mm - x, pointer.y_mm - y
        if min(abs(x - seam) for seam in seams_mm) <= SEAM_MM:
            result.off_mm.append(math.hypot(*off))
            if before is not None and t_s - before[2] < 0.1 and before[3] == pointer.id:
                result.step_mm.append(math.dist(off, before[:2]))
        before = (*off, t_s, float(pointer.id))
    if finger.crosses and len(set(ids)) == 1:
        result.kept += 1
    elif finger.crosses:
        result.wrong.append(
            f"{finger.span_s[0]:.3f} s: finger {number} has the ids {sorted(set(ids))}"
        )
