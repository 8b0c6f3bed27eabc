"""How people move a finger: reaches, taps, presses and strokes on a timeline.

Rule: pure. A `Timeline` writes segments one after the other, possibly without end; `timeline`
reads them.

Reaches follow the minimum-jerk profile (Flash and Hogan 1985). A tap is a reach through the
surface, cut off where it meets it: so the finger arrives with speed, as fingers do.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from halo_service.values import Finger, Side
from halo_service.virtual.skeleton import FingerPose

LEAST_G = 2.0
"""The lightest touch, grams."""
SHORTEST_S = 0.05
"""No finger lifts and comes down again in less; chosen."""
THROUGH = 0.7
"""How far below the table a tap is aimed, of its lift: gives strikes of 100 to 400 mm/s."""


@dataclass(frozen=True, slots=True)
class Contact:
    """One touch, exactly."""

    side: Side
    finger: Finger
    from_s: float
    to_s: float
    x_mm: float
    y_mm: float
    """Where it began, on the surface."""
    strike_mm_s: float
    """Speed towards the surface on arrival."""
    peak_force_g: float
    target_mm: tuple[float, float] | None = None
    """What was aimed at, where there was such a thing."""
    key: str | None = None


@dataclass(frozen=True, slots=True)
class Segment:
    """A part of a timeline."""

    start_s: float
    end_s: float
    pose: Callable[[float], FingerPose]
    """Pose at a time within."""
    contact: Contact | None = None
    """The touch that begins with this segment."""
    tool: str | None = None
    """What the finger rests on meanwhile."""


@dataclass(frozen=True, slots=True)
class Step:
    """A named period of a timeline."""

    name: str
    from_s: float
    to_s: float
    fields: dict[str, Any]


def smooth(share: float) -> float:
    """Minimum jerk from 0 to 1."""
    s = min(1.0, max(0.0, share))
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def smooth_speed(share: float) -> float:
    """Its derivative."""
    s = min(1.0, max(0.0, share))
    return 30.0 * s * s * (1.0 - s) ** 2


def mix(a: FingerPose, b: FingerPose, share: float) -> FingerPose:
    """The pose a share of the way from `a` to `b`."""
    return FingerPose(
        *(
            getattr(a, f.name) + (getattr(b, f.name) - getattr(a, f.name)) * share
            for f in dataclasses.fields(FingerPose)
        )
    )


def _crossing(share: float) -> float:
    """When a minimum-jerk reach has come a share of its way."""
    low, high = 0.0, 1.0
    for _ in range(50):
        middle = (low + high) / 2.0
        low, high = (middle, high) if smooth(middle) < share else (low, middle)
    return high


_CUT = _crossing(1.0 / (1.0 + THROUGH))


class Timeline:
    """Writes one finger's segments."""

    def __init__(
        self, rng: np.random.Generator, start: FingerPose, side: Side, finger: Finger = Finger.INDEX
    ) -> None:
        self.rng = rng
        self.side, self.finger = side, finger
        self.pose = start
        self.now_s = 0.0
        self.steps: list[Step] = []
        """Finished so far."""
        self.tool: str | None = None
        self._speed = 0.0

    def step(self, name: str, segments: Iterator[Segment], **fields: Any) -> Iterator[Segment]:
        """Write segments and remember them as a named step."""
        start_s = self.now_s
        yield from segments
        self.note(name, start_s, self.now_s, **fields)

    def note(self, name: str, from_s: float, to_s: float, **fields: Any) -> None:
        """Record a period as a named step."""
        self.steps.append(Step(name, from_s, to_s, fields))

    def reach(self, seconds: float, lift_mm: float = 0.0, **to: float) -> Iterator[Segment]:
        """Move to a pose (fields of FingerPose), over an arch of `lift_mm`."""
        begin, end = self.pose, dataclasses.replace(self.pose, force_g=0.0, **to)
        start_s = self.now_s

        def pose(t: float) -> FingerPose:
            s = smooth((t - start_s) / seconds)
            now = mix(begin, end, s)
            return dataclasses.replace(now, height_mm=now.height_mm + lift_mm * 4.0 * s * (1.0 - s))

        yield self._add(seconds, pose, end)

    def hold(self, seconds: float) -> Iterator[Segment]:
        """Keep the pose."""
        still = self.pose
        yield self._add(seconds, lambda t: still, still)

    def strike(self, seconds: float) -> Iterator[Segment]:
        """Come down from where the finger hovers; contact is exactly at the end."""
        begin = self.pose
        start_s, lift = self.now_s, begin.height_mm
        whole = lift * (1.0 + THROUGH)
        whole_s = seconds / _CUT

        def pose(t: float) -> FingerPose:
            fallen = whole * smooth((t - start_s) / whole_s)
            return dataclasses.replace(begin, height_mm=max(0.0, lift - fallen), force_g=0.0)

        self._speed = whole * smooth_speed(_CUT) / whole_s
        yield self._add(seconds, pose, dataclasses.replace(begin, height_mm=0.0))

    def press(
        self,
        seconds: float,
        force_g: Callable[[float], float],
        slide: Callable[[float], dict[str, float]] | None = None,
        target_mm: tuple[float, float] | None = None,
        key: str | None = None,
    ) -> Iterator[Segment]:
        """Stay in contact: force over time from 0 to 1, and where the finger slides meanwhile
        (fields of FingerPose)."""
        begin = dataclasses.replace(self.pose, height_mm=0.0)
        start_s = self.now_s

        def pose(t: float) -> FingerPose:
            s = min(1.0, max(0.0, (t - start_s) / seconds))
            moved = slide(s) if slide else {}
            return dataclasses.replace(begin, **moved, force_g=max(LEAST_G, force_g(s)))

        contact = Contact(
            self.side,
            self.finger,
            start_s,
            start_s + seconds,
            begin.x_mm,
            begin.y_mm,
            self._speed,
            max(LEAST_G, max(force_g(s) for s in np.linspace(0.0, 1.0, 33))),
            target_mm,
            key,
        )
        end = dataclasses.replace(pose(start_s + seconds), force_g=0.0)
        yield self._add(seconds, pose, end, contact)

    def tap(
        self,
        seconds: float,
        force_g: float,
        lift_mm: float,
        target_mm: tuple[float, float] | None = None,
        key: str | None = None,
    ) -> Iterator[Segment]:
        """Down, a touch of that length, and up again."""
        yield from self.strike(self.rng.uniform(0.07, 0.11))
        yield from self.press(seconds, bump(force_g), target_mm=target_mm, key=key)
        yield from self.reach(self.rng.uniform(0.1, 0.15), height_mm=lift_mm)

    def tap_at(
        self,
        when_s: float,
        seconds: float,
        force_g: Callable[[float], float],
        lift_mm: float,
        slide: Callable[[float], dict[str, float]] | None = None,
        target_mm: tuple[float, float] | None = None,
        key: str | None = None,
        to: dict[str, float] | None = None,
    ) -> Iterator[Segment]:
        """Wait, travel (`to`: fields of FingerPose), and touch at exactly `when_s`; ends where the
        contact ends, the finger still low.

        With little time the finger lifts less and comes down faster.
        """
        free = when_s - self.now_s
        if free < SHORTEST_S:
            raise ValueError(f"a finger cannot get there in {1000 * free:.0f} ms")
        down = min(0.11, 0.3 * free)
        travel = min(0.55, free - down)
        if free - down - travel > 0.0:
            rest = min(0.15, (free - down - travel) / 2.0)
            yield from self.reach(rest, height_mm=lift_mm)
            yield from self.hold(free - down - travel - rest)
        lift = lift_mm * min(1.0, travel / 0.25)
        yield from self.reach(travel, lift_mm=0.4 * lift, height_mm=0.6 * lift, **(to or {}))
        yield from self.strike(down)
        yield from self.press(seconds, force_g, slide, target_mm, key)

    def _add(
        self,
        seconds: float,
        pose: Callable[[float], FingerPose],
        end: FingerPose,
        contact: Contact | None = None,
    ) -> Segment:
        segment = Segment(self.now_s, self.now_s + seconds, pose, contact, self.tool)
        self.now_s += seconds
        self.pose = end
        return segment


def bump(peak_g: float) -> Callable[[float], float]:
    """Force of a tap: up within a third, then down."""
    return lambda s: peak_g * float(np.sin(np.pi * min(1.0, max(0.0, s)) ** 0.75) ** 0.8)


def plateau(force_g: float, rise: float = 0.25) -> Callable[[float], float]:
    """Force of a press: up, held, down."""
    return lambda s: force_g * smooth(s / rise) * smooth((1.0 - s) / rise)
