"""Replay: every frame in order, the hand tracker in step but as late as in the live service.

No clock and no threads, so the same recording gives the same frames on every run.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

from halo_service.runtime.checks import check_capture
from halo_service.runtime.method import Method, State
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame, TouchFrame, Tracked

DetectHands = Callable[[Frame], Tracked | None]

TRACKER_FRAMES_LATE = 1
"""By how many frames the tracker's hands are late, as they are live."""
FOREVER_S = 3600.0
"""A recording never waits; this is a bound all the same."""


def replay(
    source: Source,
    detect: DetectHands,
    method: Method[State],
    state: State,
    late: int = TRACKER_FRAMES_LATE,
) -> Iterator[TouchFrame]:
    """Yield one touch frame a depth frame until the recording ends.

    `detect`: the hand tracker, or its substitute; `state`: from `method.start`; `late`:
    how many frames old the tracker's hands are when a frame is sensed, 0 or more.
    Raises `UserError` if the rest of the recording cannot be read.
    """
    hands: deque[Tracked | None] = deque([None] * late, maxlen=late + 1)
    last_us: int | None = None
    while True:
        try:
            capture = source.read(FOREVER_S)
        except EndOfSource:
            return
        if capture is None:
            continue
        fault = check_capture(capture, last_us, source.camera.fps).fault
        last_us = capture.time_us
        if isinstance(capture, BadFrame) or fault is not None:
            touch_frame, state = method.clear(state, capture.time_us)
        else:
            hands.append(detect(capture))
            touch_frame, state = method.step(state, capture, hands[0])
        yield touch_frame
