"""Where a frame's CPU time goes: `uv run python benchmarks/stages.py [--frames N]`.

Draws frames of one and of two hands, then finds hands in them, senses and encodes them, as the
live service does. Prints the CPU time of each stage, ms a frame, of all threads. Stages are
measured from outside, by functions that wrap them.
"""

from __future__ import annotations

import argparse
import os
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import closing
from functools import wraps
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"  # before the imports below: as the service has it

import cv2

from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.runtime.pace import PacedTracker
from halo_service.sensing import start, step
from halo_service.settings import Settings
from halo_service.values import Frame, Tracked
from halo_service.virtual import sensor
from halo_service.virtual.depth_image import DepthImager
from halo_service.virtual.live_noise import LiveElectronics
from halo_service.virtual.noise import Electronics
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sim_url import SimRequest, parse_sim_url

SOURCES = (("one hand", "sim:pointing?seed=203&drop=0"), ("two hands", "sim:drumming?seed=202"))
FROM_S = 4.0
STAGES: tuple[tuple[Any, str, str], ...] = (
    (Scenario, "at", "virtual camera: posture"),
    (DepthImager, "draw", "virtual camera: hands drawn"),
    (sensor, "cast_shadow", "virtual camera: shadow, edges, stray light"),
    (sensor, "soften_edges", "virtual camera: shadow, edges, stray light"),
    (sensor, "add_stray_light", "virtual camera: shadow, edges, stray light"),
    (Electronics, "depth", "virtual camera: noise"),
    (LiveElectronics, "infrared", "virtual camera: noise"),
    (sensor.Sensor, "frame", "virtual camera: halo and the rest"),
    (PacedTracker, "detect", "hand tracker: whether to look"),
    (HandDetector, "_look", "hand tracker: model"),
    (step.__globals__, "look", "sensing: what is above the surface"),
    (step.__globals__, "find", "sensing: a fingertip's place and angles"),
    (step.__globals__, "measure", "sensing: the halo"),
)


class Clock:
    """CPU time by stage, without that of the stages inside."""

    def __init__(self) -> None:
        self.spent_s: dict[str, float] = defaultdict(float)
        self._inner_s: list[float] = []

    def timed(self, run: Callable[..., Any], stage: str) -> Callable[..., Any]:
        """Return the function with its time counted."""

        @wraps(run)
        def counted(*args: Any, **kwargs: Any) -> Any:
            began_s = time.process_time()
            self._inner_s.append(0.0)
            try:
                return run(*args, **kwargs)
            finally:
                took_s = time.process_time() - began_s
                self.spent_s[stage] += took_s - self._inner_s.pop()
                if self._inner_s:
                    self._inner_s[-1] += took_s

        return counted


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=300)
    count = parser.parse_args().frames
    cv2.setNumThreads(1)
    clock = Clock()
    for owner, name, stage in STAGES:
        if isinstance(owner, dict):
            owner[name] = clock.timed(owner[name], stage)
        else:
            setattr(owner, name, clock.timed(getattr(owner, name), stage))
    found = []
    for _, source in SOURCES:
        run(parse_sim_url(source), count, clock)
        found.append({stage: 1000.0 * spent_s / count for stage, spent_s in clock.spent_s.items()})
    print(f"{'CPU, ms a frame':46}" + "".join(f"{name:>11}" for name, _ in SOURCES))
    for stage in found[0]:
        print(f"{stage:46}" + "".join(f"{each[stage]:11.2f}" for each in found))
    for part in ("virtual camera", "hand tracker", "sensing"):
        sums = (sum(ms for stage, ms in each.items() if stage.startswith(part)) for each in found)
        print(f"{part + ', sum':46}" + "".join(f"{ms:11.2f}" for ms in sums))


def run(request: SimRequest, count: int, clock: Clock) -> None:
    """Draw the frames, then sense them."""
    settings = Settings()
    profile = cached_profile(request.room, settings, virtual_profile)
    running = start_scenario(request.scenario, request.room)
    camera = sensor.Sensor(request.room, colour_times=0, live=True)
    encode = clock.timed(FrameEncoder("bench", "s0", 0).encode, "encoding")
    sense = clock.timed(step, "sensing: the rest")

    def draw(number: int) -> Frame:
        moment = running.at(FROM_S + number / 30.0)
        return camera.frame(round(1e6 * (FROM_S + number / 30.0)), moment.hands, moment.things)

    draw(0)  # builds what is built once
    clock.spent_s.clear()
    frames = [draw(number) for number in range(1, count + 1)]
    late: Tracked | None = None
    state = start(profile, settings.sensing)
    with closing(HandDetector(profile.camera, profile, settings.tracking, paced=True)) as detector:
        for frame in frames:
            touch_frame, state = sense(state, frame, late)
            encode(touch_frame)
            late = detector.detect(frame)


if __name__ == "__main__":
    main()
