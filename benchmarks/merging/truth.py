"""Fingers on a canvas of two or four surfaces: where they truly are, and when they touch.

Time is in seconds since the start; places are mm on the canvas.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

LIFT_MM = 12.0
"""Height of a finger between two taps."""
REST_S = 0.7
"""Between two crossings there is no finger."""


@dataclass(frozen=True, slots=True)
class Finger:
    """One finger from its first to its last moment."""

    corners: tuple[tuple[float, float, float], ...]
    """(time, x, y): where it passes, with straight lines at constant speed between them."""
    touches: tuple[tuple[float, float], ...]
    """(down, up) in s."""
    finger: int = 1
    hand: int = 2
    crosses: bool = True
    """Whether it goes from one side of a seam to the other."""

    @property
    def span_s(self) -> tuple[float, float]:
        """First and last moment."""
        return self.corners[0][0], self.corners[-1][0]

    def place_mm(self, t_s: float) -> tuple[float, float]:
        """Where it is."""
        times = [corner[0] for corner in self.corners]
        after = min(max(bisect_right(times, t_s), 1), len(times) - 1)
        (t0, x0, y0), (t1, x1, y1) = self.corners[after - 1], self.corners[after]
        share = min(max((t_s - t0) / (t1 - t0), 0.0), 1.0)
        return x0 + share * (x1 - x0), y0 + share * (y1 - y0)

    def velocity_mm_s(self, t_s: float) -> tuple[float, float]:
        """How it moves, over the last 33 ms as a node measures it."""
        (x0, y0), (x1, y1) = self.place_mm(t_s - 0.033), self.place_mm(t_s)
        return (x1 - x0) / 0.033, (y1 - y0) / 0.033

    def touching(self, t_s: float) -> bool:
        """Whether it touches."""
        return any(down <= t_s < up for down, up in self.touches)


@dataclass(slots=True)
class Truth:
    """All fingers of a run, in order of time."""

    fingers: list[Finger] = field(default_factory=list)
    end_s: float = 0.0

    def at(self, t_s: float) -> Iterator[tuple[int, Finger]]:
        """Yield the fingers that are there."""
        for number, finger in enumerate(self.fingers):
            if finger.span_s[0] <= t_s < finger.span_s[1]:
                yield number, finger


def crossings(count: int, seams_mm: list[float], height_mm: float, seed: int) -> Truth:
    """Return fingers that cross vertical seams, `count` crossings at least, one kind by another."""
    random = np.random.default_rng(seed)
    truth = Truth(end_s=1.0)
    done = 0
    while done < count:
        seam_mm = float(random.choice(seams_mm))
        y_mm = float(random.uniform(70.0, height_mm - 70.0))
        kind = KINDS[int(random.integers(len(KINDS)))]
        fingers = kind(random, seam_mm, y_mm, truth.end_s)
        truth.fingers += fingers
        done += sum(finger.crosses for finger in fingers)
        truth.end_s = max(finger.span_s[1] for finger in fingers) + REST_S
    return truth


def slide(random: np.random.Generator, seam: float, y: float, start: float) -> list[Finger]:
    """Touch on one side, slide over the seam, lift on the other side."""
    speed, far = random.uniform(100.0, 700.0), random.uniform(70.0, 100.0)
    way = float(random.choice((-1.0, 1.0)))
    duration = 2.0 * far / speed
    rest = 0.25
    corners = (
        (start, seam - way * far, y),
        (start + rest, seam - way * far, y),
        (start + rest + duration, seam + way * far, y + random.uniform(-30.0, 30.0)),
        (start + 2 * rest + duration, seam + way * far, y),
    )
    return [Finger(corners, ((start + 0.15, start + 1.6 * rest + duration),))]


def hover(random: np.random.Generator, seam: float, y: float, start: float) -> list[Finger]:
    """Hover over the seam, then tap on the other side."""
    (finger,) = slide(random, seam, y, start)
    end = finger.span_s[1]
    return [Finger(finger.corners, ((end - 0.2, end - 0.1),))]


def taps(random: np.random.Generator, seam: float, y: float, start: float) -> list[Finger]:
    """Tap quickly on the seam; the finger comes from one side and leaves on the other."""
    count, period = int(random.integers(2, 6)), random.uniform(0.13, 0.3)
    x = seam + random.uniform(-15.0, 15.0)
    way = float(random.choice((-1.0, 1.0)))
    begin = start + 0.35
    touches = tuple(
        (begin + i * period, begin + i * period + random.uniform(0.04, 0.5 * period))
        for i in range(count)
    )
    end = begin + count * period
    corners = (
        (start, x - way * 90.0, y),
        (start + 0.3, x, y),
        (end, x, y),
        (end + 0.3, x + way * 90.0, y),
    )
    return [Finger(corners, touches)]


def pair(random: np.random.Generator, seam: float, y: float, start: float) -> list[Finger]:
    """Slide two neighbouring fingers of one hand over the seam."""
    (index,) = slide(random, seam, y, start)
    angle, apart = random.uniform(0.0, 2.0 * math.pi), random.uniform(20.0, 30.0)
    dx, dy = apart * math.cos(angle), apart * math.sin(angle)
    moved = tuple((t, x + dx, y + dy) for t, x, y in index.corners)
    late = random.uniform(-0.04, 0.04)
    ((down, up),) = index.touches
    return [index, Finger(moved, ((down + late, up + late),), finger=2)]


def turn(random: np.random.Generator, seam: float, y: float, start: float) -> list[Finger]:
    """Slide over the seam and back twice without lifting."""
    (one,) = slide(random, seam, y, start)
    (t0, x0, y0), (t1, x1, y1), (t2, x2, y2), _ = one.corners
    duration = t2 - t1
    corners = [(t0, x0, y0)]
    for leg in range(4):
        x = x1 if leg % 2 == 0 else x2
        corners.append((t1 + leg * duration, x, y1 if leg % 2 == 0 else y2))
    end = t1 + 3 * duration + 0.2
    corners.append((end, x2, y2))
    return [Finger(tuple(corners), ((t0 + 0.15, end - 0.1),))]


KINDS = (slide, hover, taps, pair, turn)
