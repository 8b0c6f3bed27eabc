"""What the nodes of a virtual installation publish, in step: the same lines on every run.

Each camera's frames go through the hand tracker and the sensing as in `halo replay`. Times in a
line are those of the camera's own clock; `arrived_us` is when the line reaches the canvas's
machine, on the host clock of the installation.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import numpy as np

from halo_service.app.hand_detector import HandDetector
from halo_service.evaluation.study.sense import FrameSequence
from halo_service.outputs.jsonl import frame_line
from halo_service.profile import Profile
from halo_service.runtime.method import OURS
from halo_service.runtime.replay import replay
from halo_service.settings import Settings
from halo_service.values import Frame
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.sim_url import SimRequest

DELAY_MS, LATE_MS = 27.0, 4.0
"""From the exposure to the arrival: the least, and the mean of what is added; chosen near the
latency of the live service."""


def node_stream(
    request: SimRequest,
    profile: Profile,
    settings: Settings,
    node: str,
    seconds: float,
    advance: Callable[[], None] = lambda: None,
) -> Iterator[dict[str, Any]]:
    """Yield a line of `halo replay` for each frame of one camera, with `arrived_us`.

    `profile`: of this camera; `advance` is called for each frame.
    """
    room = request.room
    recording = SimulatedRecording(request, seconds, colour=False, whole_ms=False)
    rng = np.random.default_rng([*room.noise_seed, 8])

    def captures() -> Iterator[Frame]:
        for frame, _ in recording:
            advance()
            if frame is not None:
                yield frame

    source = FrameSequence(captures(), recording.camera)
    state = OURS.start(profile, settings.sensing)
    tracker = HandDetector(recording.camera, profile, settings.tracking, paced=OURS.paced)
    with closing(tracker) as detector:
        for count, frame in enumerate(replay(source, detector.detect, OURS, state)):
            delay_us = 1000.0 * (DELAY_MS + float(rng.exponential(LATE_MS)))
            exposed_us = 1e6 * recording.clock.host_s(frame.time_us)
            line = json.loads(frame_line(frame, node, f"sim{room.seed}", count))
            yield {"arrived_us": round(exposed_us + delay_us), **line}
