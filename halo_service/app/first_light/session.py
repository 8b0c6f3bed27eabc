"""One session: prompts, the finger that follows them, and a recording of what counts.

Rule: the recording has only the frames in which something is done, and of those only what is near
the crosses, with infrared rounded to a share of its level. So half an hour stays below 200 MB.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halo_calibration.boards.sheets import CROSSES_MM
from halo_calibration.guided.guide import Prompt
from halo_calibration.observe import Observation
from halo_service.app.first_light.announce import Announcer
from halo_service.app.first_light.pace import Pace, State
from halo_service.app.first_light.plan import Task
from halo_service.geometry.k4a import DEPTH_FPS
from halo_service.profile import Profile
from halo_service.sensing.background import DRIFT_GRID
from halo_service.values import Frame

BEFORE_S = 0.4
"""Recorded before a finger is felt: the hand is found and followed in it."""
SETTLING_S = 2.4
"""Recorded before a level is held, one frame in `THINNED`: the finger comes down in it."""
MOST_FRAMES = round(max(DEPTH_FPS.values()) * SETTLING_S) + 1
"""As many at the highest rate; more are not kept, even if the camera's clock goes back."""
THINNED = 3
AFTER_S = 0.2
MISSED_S = 1.5
"""Recorded of a touch that was not felt."""
ASIDE_MM, BEYOND_MM, NEAR_MM = 70.0, 40.0, 170.0
"""Around the crosses, to both sides, away from the user and towards: a hand as far as its wrist."""
ROUNDED = 16
"""Infrared is rounded to this part of its median, an error of less than 2 %."""
AWAY = Prompt("away", "Take the hand away.")


@dataclass
class Followed:
    """What came out of a session."""

    lines: list[dict[str, Any]] = field(default_factory=list)
    """The script, in the recording's own time."""
    live_lines: list[dict[str, Any]] = field(default_factory=list)
    """The script, in seconds from the session's first frame."""
    frames: int = 0
    missed: list[str] = field(default_factory=list)
    """The words of the tasks that were not felt, or not held still."""


class Cutter:
    """Leaves out of a frame what the evaluation does not need."""

    def __init__(self, profile: Profile, frame: Frame) -> None:
        """`frame`: of the empty table; its infrared says how much rounding is fine."""
        self._inside = near_crosses(profile)
        self._inside[DRIFT_GRID] = True
        level = float(np.median(frame.ir[self._inside]))
        self._step = max(1, 2 ** int(np.log2(max(level / ROUNDED, 1.0))))

    def cut(self, frame: Frame) -> Frame:
        """Return the frame without colour and without what is far from the crosses."""
        depth = np.where(self._inside, frame.depth, 0).astype(np.uint16)
        ir = np.where(self._inside, frame.ir // self._step * self._step, 0).astype(np.uint16)
        return replace(frame, depth=depth, ir=ir, colour=None)


def near_crosses(profile: Profile) -> NDArray[np.bool_]:
    """Return which pixels of the depth image see the crosses or a place near them: (H, W)."""
    lens, surface = profile.camera.depth, profile.surface
    rows, columns = np.mgrid[0 : lens.height, 0 : lens.width]
    px = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
    x_mm, y_mm = surface.seen_at(px, lens, np.eye(4)).T
    half = max(x for x, _ in CROSSES_MM)
    y_mm = y_mm - surface.height_mm / 2.0
    inside = np.abs(x_mm - surface.width_mm / 2.0) < half + ASIDE_MM
    inside &= (y_mm > -half - BEYOND_MM) & (y_mm < half + NEAR_MM)
    return np.asarray(inside.reshape(lens.height, lens.width), dtype=np.bool_)


def follow_tasks(
    tasks: Sequence[Task],
    frames: Iterator[Frame],
    see: Callable[[Frame], Observation | None],
    announcer: Announcer,
    keep: Callable[[Frame], None],
    touch_raw: float,
) -> Followed:
    """Go through the tasks as the finger does them; pass each frame that counts to `keep`.

    Times of kept frames and of the script start at the first kept frame. `touch_raw`: see `Pace`.
    """
    followed = Followed()
    tape = _Tape(keep)
    for number, task in enumerate(tasks, 1):
        announcer.prompt(task.prompt, f"{number} of {len(tasks)}")
        pace = _follow_one(task, frames, see, announcer, tape, touch_raw)
        if pace.state is State.MISSED:
            announcer.say("not felt or not held still; go on with the next one")
            followed.missed.append(task.prompt.words)
        if pace.state is State.DONE or task.step == "target":  # a missed touch counts as missed
            followed.lines.append(_line(task, pace, tape.seconds))
            followed.live_lines.append(_line(task, pace, tape.live_seconds))
        if task.kind in ("hover", "pressure"):
            announcer.prompt(AWAY)
            _wait_until_gone(frames, see)
    followed.frames = tape.count
    return followed


def _follow_one(
    task: Task,
    frames: Iterator[Frame],
    see: Callable[[Frame], Observation | None],
    announcer: Announcer,
    tape: _Tape,
    touch_raw: float,
) -> Pace:
    pace, after_us, again = Pace(task.kind, touch_raw), 0, 0
    for frame in frames:
        before = pace.state
        if before in (State.DONE, State.MISSED):
            tape.write(frame)
            if frame.time_us >= after_us:
                return pace
            continue
        state = pace.feed(frame.time_us, see(frame))
        if pace.again > again:
            again = pace.again
            announcer.tone("again")
        if state in (State.DOWN, State.HOLDING) and before is State.WAITING:
            if state is State.HOLDING:
                tape.start(frame.time_us - round(SETTLING_S * 1e6), THINNED)
                announcer.tone("ready")
            else:
                tape.start(frame.time_us - round(BEFORE_S * 1e6))
        if state is State.MISSED:
            tape.start(frame.time_us - round(MISSED_S * 1e6))
        if state in (State.DONE, State.MISSED):
            announcer.tone("done" if state is State.DONE else "again")
            after_us = frame.time_us + round(AFTER_S * 1e6)
        tape.offer(frame, state is not State.WAITING)
    return pace


def _line(task: Task, pace: Pace, seconds: Callable[[int], float]) -> dict[str, Any]:
    """Return a task's line of the script. A touch may begin before it is felt."""
    begin, end = pace.from_us, pace.to_us
    if task.kind in ("touch", "tap"):
        begin -= round(0.8 * (BEFORE_S if pace.state is State.DONE else MISSED_S) * 1e6)
        end += round(0.8 * AFTER_S * 1e6)
    return {
        "step": task.step,
        "from_s": seconds(begin),
        "to_s": seconds(end),
        **task.fields,
    }


def _wait_until_gone(frames: Iterator[Frame], see: Callable[[Frame], Observation | None]) -> None:
    """Wait until no finger is seen for a moment."""
    unseen = 0
    for frame in frames:
        unseen = unseen + 1 if see(frame) is None else 0
        if unseen >= 5:
            return


class _Tape:
    """Keeps the last frames, and passes on those that count, once each."""

    def __init__(self, keep: Callable[[Frame], None]) -> None:
        self._keep = keep
        self._recent: deque[Frame] = deque(maxlen=MOST_FRAMES)
        self._first_us: int | None = None
        self._live_us: int | None = None
        self._written_us = -1
        self.count = 0

    def offer(self, frame: Frame, counts: bool) -> None:
        """Remember a frame, or pass it on if it counts."""
        self._live_us = frame.time_us if self._live_us is None else self._live_us
        if counts:
            self.write(frame)
            return
        self._recent.append(frame)
        while frame.time_us - self._recent[0].time_us > SETTLING_S * 1e6:
            self._recent.popleft()

    def start(self, from_us: int, every: int = 1) -> None:
        """Pass on what is remembered, from a time on: one frame in `every`."""
        for frame in [each for each in self._recent if each.time_us >= from_us][::every]:
            self.write(frame)
        self._recent.clear()

    def write(self, frame: Frame) -> None:
        """Pass on a frame, in the recording's own time."""
        if frame.time_us <= self._written_us:
            return
        self._written_us = frame.time_us
        self._first_us = frame.time_us if self._first_us is None else self._first_us
        self._keep(replace(frame, time_us=frame.time_us - self._first_us))
        self.count += 1

    def seconds(self, time_us: int) -> float:
        """Return a time as the script has it."""
        return max(0.0, (time_us - (self._first_us or 0)) / 1e6)

    def live_seconds(self, time_us: int) -> float:
        """Return a time as counted from the session's first frame."""
        return max(0.0, (time_us - (self._live_us or 0)) / 1e6)
