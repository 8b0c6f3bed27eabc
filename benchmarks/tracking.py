"""Is infrared alone enough for the hand tracker? `python benchmarks/tracking.py [SIM ...]`.

Two trackers get the same virtual recordings, one as the paper's blend of infrared and colour, one
as infrared alone. It prints how often each index finger is found, how far landmark 8 is from the
true pad, and the CPU time of a frame. The virtual hand's infrared is plainly shaded, so the result
may not hold for skin.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

os.environ["OMP_NUM_THREADS"] = "1"  # before the imports below: as the service holds it

import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.latency.raw_frames import to_raw, unpack
from halo_service.hand_tracking.blend import ColourWarp, Picture, blend
from halo_service.hand_tracking.hands import HandTracker
from halo_service.hand_tracking.model import hand_model
from halo_service.values import Finger, Frame
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import SimRequest, parse_sim_url

SOURCES = (
    *(f"sim:pointing?seed={seed}" for seed in (201, 202, 203, 204)),
    "sim:projector?seed=203", "sim:drumming?seed=202", "sim:drumming?seed=205",
    "sim:chaos?seed=204",
)  # fmt: skip
OPENING_S, SECONDS = 3.5, 5.0
NEAR_PX = 40.0
"""A landmark farther off is not this finger."""
LANDMARK = 8
Look = Callable[[Frame], Picture]
Pixel = NDArray[np.float64]


class TrackerScore:
    """One tracker and its results."""

    def __init__(self, picture: Look, hands: int) -> None:
        self._picture = picture
        self.tracker = HandTracker(hand_model(None), hands)
        self.cpu_s, self.wanted = 0.0, 0
        self.off_px: list[float] = []

    def see(self, frame: Frame, pads: list[Pixel]) -> None:
        """Track one frame with its true pads."""
        start_s = time.process_time()
        found = self.tracker.find(self._picture(frame), frame.time_us).hands
        self.cpu_s += time.process_time() - start_s
        self.wanted += len(pads)
        for pad in pads:
            off = [float(np.hypot(*(hand.landmarks_px[LANDMARK] - pad))) for hand in found]
            if off and min(off) < NEAR_PX:
                self.off_px.append(min(off))


def main() -> int:
    """Print two lines a recording."""
    for source in sys.argv[1:] or SOURCES:
        request = parse_sim_url(source)
        sensor = Sensor(request.room)
        shape = (sensor.camera.depth.height, sensor.camera.depth.width)
        warp = ColourWarp(sensor.camera, np.full(shape, request.room.camera_height_mm, np.float32))
        hands = 2 if request.scenario == "drumming" else 1
        scores = {name: TrackerScore(picture, hands) for name, picture in pictures(warp).items()}
        count = round(SECONDS * sensor.camera.fps)
        with ExitStack() as stack:
            for score in scores.values():
                stack.callback(score.tracker.close)
            for frame, pads in simulate(request, sensor, count):
                for score in scores.values():
                    score.see(frame, pads)
        for name, score in scores.items():
            median, p95 = np.percentile(score.off_px or [np.nan], (50, 95))
            print(
                f"{source:26} {name:14} found {len(score.off_px) / score.wanted:6.1%}  off "
                f"{median:4.1f} px, p95 {p95:4.1f}  CPU {1000 * score.cpu_s / count:5.1f} ms",
                flush=True,
            )
    return 0


def pictures(warp: ColourWarp) -> dict[str, Look]:
    """The two images of a frame."""
    return {
        "blend": lambda frame: blend(frame.ir, frame.colour, warp, frame.depth),
        "infrared alone": lambda frame: blend(frame.ir, None, warp, frame.depth),
    }


def simulate(
    request: SimRequest, sensor: Sensor, count: int
) -> Iterator[tuple[Frame, list[Pixel]]]:
    """Yield frames and the true pads of their index fingers, px."""
    scenario, lens = start_scenario(request.scenario, request.room), sensor.camera.depth
    fps = sensor.camera.fps
    first = round(OPENING_S * fps)
    for index in range(first + count):
        stage = scenario.at(index / fps)
        if index < first:
            continue
        drawn = sensor.frame(round(index / fps * 1e6), stage.hands, stage.things)
        pads = [hand.pad(Finger.INDEX) for hand in stage.hands if hand.pointing(Finger.INDEX)]
        seen = [lens.project(sensor.surface.to_camera(pad[None]))[0] for pad in pads]
        inside = [px for px in seen if 0 <= px[0] < lens.width and 0 <= px[1] < lens.height]
        yield unpack(to_raw(drawn), sensor.camera), inside


if __name__ == "__main__":
    raise SystemExit(main())
