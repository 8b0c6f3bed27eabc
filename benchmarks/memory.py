"""Is the service's memory flat? `uv run python benchmarks/memory.py [--frames N]`.

Runs the service's loop with its hand tracker and its OSC output on virtual frames, as fast as it
can, and prints the memory of the process after each tenth. Six seconds of frames are drawn once and
used again with later times; 100,000 of them are an hour of a camera and take about nine minutes of
one core. Ends with 1 if the last half grew by more than 5 MB.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"  # before the imports below: as the service has it

import cv2

from halo_service.app.hand_detector import HandDetector
from halo_service.app.service.publisher import Publisher
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.outputs.destination import Destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.osc import OscOutput
from halo_service.runtime.memory import memory_mb
from halo_service.sensing import start, step
from halo_service.settings import Settings
from halo_service.values import Frame, Tracked
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.sim_url import parse_sim_url

SOURCE = "sim:pointing?seed=203&drop=0"
FROM_S, DRAWN_S = 4.0, 10.0
FRAME_US = 33_333
ALLOWED_MB = 5
PORT = 9
"""The discard port: packets go out and arrive at no program."""


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=100_000)
    count = parser.parse_args().frames
    cv2.setNumThreads(1)
    request, settings = parse_sim_url(SOURCE), Settings()
    profile = cached_profile(request.room, settings, virtual_profile)
    recording = SimulatedRecording(request, DRAWN_S, colour=False, start_s=FROM_S)
    drawn = [frame for frame, _ in recording if frame]
    output = OscOutput([Destination("127.0.0.1", PORT)])
    publisher = Publisher(
        FrameEncoder("bench", "s0", 0), [output], "virtual", profile.camera, profile.surface.name
    )
    with (
        closing(output),
        closing(HandDetector(profile.camera, profile, settings.tracking, paced=True)) as detector,
    ):
        memory = run(drawn, count, detector.detect, start(profile, settings.sensing), publisher)
    grown_mb = memory[-1] - memory[len(memory) // 2]
    print(f"the last half grew by {grown_mb} MB")
    return int(grown_mb > ALLOWED_MB)


def run(
    drawn: list[Frame],
    count: int,
    detect: Callable[[Frame], Tracked],
    state: Any,
    publisher: Publisher,
) -> list[int]:
    """Sense and send `count` frames; return the memory after each tenth, MB."""
    late: Tracked | None = None
    memory: list[int] = []
    for number in range(count):
        frame = replace(drawn[number % len(drawn)], time_us=FRAME_US * (number + 1))
        touch_frame, state = step(state, frame, late)
        publisher.frame(touch_frame)
        late = detect(frame)
        if (number + 1) % (count // 10) == 0:
            memory.append(memory_mb())
            print(f"after {number + 1:7} frames {memory[-1]:5} MB", flush=True)
    return memory


if __name__ == "__main__":
    raise SystemExit(main())
