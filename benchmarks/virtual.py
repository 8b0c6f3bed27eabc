"""What the virtual camera costs: time of one core a frame, frames a second offline, memory.

    uv run python benchmarks/virtual.py [--frames N]

The bar (two slow cores): live with one hand at most 25 ms of a core at the median; offline with
two hands at least 15 frames a second at full quality; memory flat over 10,000 frames.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # before the import below: one core is what is measured

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from halo_service.virtual.worker import LIVE_COLOUR_TIMES

CASES = (
    ("live, one hand", "demo", LIVE_COLOUR_TIMES, 1.0),
    ("live, two hands", "drumming", LIVE_COLOUR_TIMES, 5.0),
    ("live, one hand in projected light", "projector", LIVE_COLOUR_TIMES, 1.0),
    ("full quality, one hand", "demo", 1, 1.0),
    ("full quality, two hands", "drumming", 1, 5.0),
    ("full quality, ten fingers", "ten-fingers", 1, 6.0),
)
"""What it is called, scenario, how much smaller colour is drawn, and from when it is busy."""


def cost_ms(scenario: str, colour_times: int, from_s: float, frames: int) -> NDArray[np.float64]:
    """CPU time of each frame, ms."""
    request = parse_sim_url(f"sim:{scenario}?drop=0")
    running, sensor = (
        start_scenario(request.scenario, request.room),
        Sensor(request.room, colour_times=colour_times, live=colour_times > 1),
    )
    costs = []
    for k in range(frames + 5):
        t_s = from_s + k / 30.0
        begin = time.process_time()
        stage = running.at(t_s)
        sensor.frame(round(t_s * 1e6), stage.hands, stage.things)
        costs.append(1000.0 * (time.process_time() - begin))
    return np.array(costs[5:])


def resident_mb() -> float:
    """Memory of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def memory(frames: int) -> tuple[float, float]:
    """MB after a tenth of the frames and after all of them."""
    request = parse_sim_url("sim:drumming?drop=0")
    running, sensor = (
        start_scenario(request.scenario, request.room),
        Sensor(request.room, colour_times=0),
    )
    early = 0.0
    for k in range(frames):
        stage = running.at(k / 30.0)
        running.ended_contacts(k / 30.0)
        sensor.frame(k * 33_333, stage.hands, stage.things)
        if k == frames // 10:
            early = resident_mb()
    return early, resident_mb()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000, help="for the memory, default 10000")
    count = parser.parse_args().frames
    cv2.setNumThreads(1)
    for name, scenario, times, from_s in CASES:
        costs = cost_ms(scenario, times, from_s, 150)
        median, p95 = np.percentile(costs, (50, 95))
        print(
            f"{name:35} {median:5.1f} ms of a core, p95 {p95:5.1f}  {1000 / median:5.1f} frames/s"
        )
    early, late = memory(count)
    print(f"memory after {count // 10} frames {early:.1f} MB, after {count} {late:.1f} MB")


if __name__ == "__main__":
    main()
