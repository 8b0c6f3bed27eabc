"""What really happened: the truth's lines, converted to the surface's frame.

Rule: pure. The metrics see this and the published frames, and nothing else.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from halo_service.geometry.surface import Surface
from halo_service.values import Finger, Side

BEYOND_MM = 20.0
"""What is touched farther outside the surface is no touch of it (`edge_margin_mm` in halo.toml)."""

Line = dict[str, Any]
"""One line of a truth or script file."""


@dataclass(frozen=True, slots=True)
class TrueFinger:
    """One pointing finger in one depth frame."""

    side: Side
    finger: Finger
    x_mm: float
    y_mm: float
    """The pad's lowest point, surface frame."""
    height_mm: float
    touching: bool
    force_g: float


@dataclass(frozen=True, slots=True)
class TrueFrame:
    """All pointing fingers in view at one depth frame."""

    time_us: int
    fingers: tuple[TrueFinger, ...]

    def find(self, side: Side, finger: Finger) -> TrueFinger | None:
        """That finger, where it is in view."""
        return next((f for f in self.fingers if (f.side, f.finger) == (side, finger)), None)


@dataclass(frozen=True, slots=True)
class TrueTouch:
    """One contact, exactly."""

    side: Side
    finger: Finger
    from_us: int
    to_us: int
    x_mm: float
    y_mm: float
    """Where it began, surface frame."""
    strike_mm_s: float
    target_mm: tuple[float, float] | None
    """The target, surface frame; None without one."""
    key: str | None
    frames: int
    """How many depth frames show it."""
    ended: bool = True
    """False for a touch that the recording's end cuts off: it is neither hit nor missed."""
    beyond: bool = False
    """Whether it is beyond the surface and its margin: neither hit nor missed too."""

    @property
    def aim_mm(self) -> tuple[float, float]:
        """The target, or the place itself where there was none."""
        return self.target_mm or (self.x_mm, self.y_mm)


@dataclass(frozen=True, slots=True)
class Truth:
    """What is true of one recording, in order of time."""

    frames: tuple[TrueFrame, ...]
    touches: tuple[TrueTouch, ...]

    def at(self, time_us: int) -> TrueFrame | None:
        """The frame of exactly that time."""
        index = bisect_left(self.frames, time_us, key=_time)
        found = index < len(self.frames) and self.frames[index].time_us == time_us
        return self.frames[index] if found else None


def read_truth(lines: Sequence[Line], surface: Surface) -> Truth:
    """Convert the truth to a surface's frame; raises KeyError for lines that are no truth."""
    frames = tuple(
        sorted((_frame(each, surface) for each in lines if "fingers" in each), key=_time)
    )
    times = [frame.time_us for frame in frames]
    touches = [_touch(each["contact"], surface, times) for each in lines if "contact" in each]
    touches += _cut_off(frames, touches)
    return Truth(frames, tuple(sorted(touches, key=lambda touch: touch.from_us)))


def _frame(line: Line, surface: Surface) -> TrueFrame:
    fingers = line["fingers"]
    camera_mm = np.array([each["camera_mm"] for each in fingers], np.float64).reshape(-1, 3)
    places = surface.from_camera(camera_mm).tolist()
    return TrueFrame(
        line["time_us"],
        tuple(
            TrueFinger(
                *_who(each), x, y, each["height_mm"], bool(each["touching"]), each["force_g"]
            )
            for each, (x, y, _) in zip(fingers, places, strict=True)
        ),
    )


def _touch(line: Line, surface: Surface, times: Sequence[int]) -> TrueTouch:
    x, y, _ = surface.from_camera(np.array([line["camera_mm"]], np.float64))[0].tolist()
    target = line.get("target_mm")
    from_us, to_us = line["from_us"], line["to_us"]
    return TrueTouch(
        *_who(line),
        from_us,
        to_us,
        x,
        y,
        line["strike_mm_s"],
        (target[0], target[1]) if target else None,
        line.get("key"),
        bisect_right(times, to_us) - bisect_left(times, from_us),
        beyond=_outside_mm(target[0] if target else x, target[1] if target else y, surface)
        > BEYOND_MM,
    )


def _outside_mm(x_mm: float, y_mm: float, surface: Surface) -> float:
    """Return how far a place is outside the surface, 0 on it."""
    dx = max(-x_mm, x_mm - surface.width_mm, 0.0)
    dy = max(-y_mm, y_mm - surface.height_mm, 0.0)
    return math.hypot(dx, dy)


def _cut_off(frames: Sequence[TrueFrame], touches: Sequence[TrueTouch]) -> list[TrueTouch]:
    """Return the touches still going on in the last frame: the truth lists a contact at its end."""
    open_ = []
    for last in frames[-1].fingers if frames else ():
        since = _touching_since(frames, last) if last.touching else []
        listed = any(t.to_us >= frames[-1].time_us and _same(t, last) for t in touches)
        if since and not listed:
            begin = since[0].find(last.side, last.finger) or last
            open_.append(
                TrueTouch(
                    last.side, last.finger, since[0].time_us, frames[-1].time_us,
                    begin.x_mm, begin.y_mm, 0.0, None, None, len(since), ended=False,
                )
            )  # fmt: skip
    return open_


def _touching_since(frames: Sequence[TrueFrame], finger: TrueFinger) -> list[TrueFrame]:
    """Return the frames at the end in which that finger touched without a break."""
    since: list[TrueFrame] = []
    for frame in reversed(frames):
        now = frame.find(finger.side, finger.finger)
        if now is None or not now.touching:
            break
        since.insert(0, frame)
    return since


def _same(touch: TrueTouch, finger: TrueFinger) -> bool:
    return (touch.side, touch.finger) == (finger.side, finger.finger)


def _who(line: Line) -> tuple[Side, Finger]:
    return Side[line["hand"].upper()], Finger[line["finger"].upper()]


def _time(frame: TrueFrame) -> int:
    return frame.time_us
