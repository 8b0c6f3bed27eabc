"""Replay: every frame in order, the hand tracker in step but as late as it is live.

No clock and no threads, so the same recording gives the same frames on every run.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

from halo_service.runtime.checks import judge
from halo_service.runtime.method import Method, State
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame, TouchFrame, Tracked

Look = Callable[[Frame], Tracked | None]

TRACKER_FRAMES_LATE = 1
"""How many frames the tracker's hands come late, as they do live."""
FOREVER_S = 3600.0
"""A recording never lets one wait; this bounds it all the same."""


def replay(
    source: Source,
    look: Look,
    method: Method[State],
    state: State,
    late: int = TRACKER_FRAMES_LATE,
) -> Iterator[TouchFrame]:
    """Yield one touch frame a depth frame until the recording ends.

    `look`: the hand tracker, or what stands for it; `state`: what `method.start` gave; `late`:
    how many frames old the tracker's hands are when a frame is sensed, 0 or more.
    Raises `UserError` where the recording cannot be read on.
    """
    seen: deque[Tracked | None] = deque([None] * late, maxlen=late + 1)
    last_us: int | None = None
    while True:
        try:
            capture = source.read(FOREVER_S)
        except EndOfSource:
            return
        if capture is None:
            continue
        fault = judge(capture, last_us, source.camera.fps).fault
        last_us = capture.time_us
        if isinstance(capture, BadFrame) or fault is not None:
            told, state = method.clear(state, capture.time_us)
        else:
            seen.append(look(capture))
            told, state = method.step(state, capture, seen[0])
        yield told
