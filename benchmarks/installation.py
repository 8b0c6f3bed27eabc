"""How well a canvas merges real sensing: `uv run python benchmarks/installation.py FOLDER`.

Two to six virtual cameras see hands that cross from one area to the next. Each camera is calibrated
by `halo calibrate`, and its frames go through the hand tracker and the sensing. The streams of the
nodes are merged in the order of their arrival and compared with the one truth. FOLDER caches
profiles and streams: another run merges them again.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # before the imports below: as the service has it

import cv2
from merging.picture import draw
from merging.sensed import merged
from merging.sensed_score import score

from halo_service.app.recordings.node_streams import node_stream
from halo_service.files import appearing
from halo_service.profile.store import exists, load
from halo_service.settings import Settings
from halo_service.virtual.installation.truth import canvas_truth, layout_text
from halo_service.virtual.sim_url import SimRequest, parse_sim_url


@dataclass(frozen=True, slots=True)
class Camera:
    """One camera of one installation."""

    folder: Path
    name: str
    """Of the source, without its camera."""
    number: int
    seconds: float

    @property
    def request(self) -> SimRequest:
        """What it shows."""
        return parse_sim_url(self.source)

    @property
    def source(self) -> str:
        """As `--source` has it."""
        return f"{self.name},camera={self.number}"

    @property
    def profile(self) -> Path:
        """Its calibration."""
        return self.folder / f"profile-{self.number}"

    @property
    def stream(self) -> Path:
        """What its node publishes."""
        return self.folder / f"camera-{self.number}.jsonl"


def main() -> int:
    """Make what is missing, merge it and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--cameras", type=int, default=2)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--options", default="", help="more of the source, e.g. sync=none")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--wrong", action="store_true", help="list what went wrong")
    parser.add_argument("--picture", type=Path, metavar="X.png", help="draw a part of it")
    parser.add_argument("--span", type=float, nargs=2, default=(1.0, 28.0), help="that part, in s")
    options = parser.parse_args()
    name = f"sim:crossing,cameras={options.cameras},seed={options.seed}"
    name += f",{options.options}" if options.options else ""
    options.folder.mkdir(parents=True, exist_ok=True)
    numbers = range(1, options.cameras + 1)
    cameras = [Camera(options.folder, name, number, options.seconds) for number in numbers]
    with ProcessPoolExecutor(options.jobs) as pool:
        list(pool.map(make, cameras))
    request = cameras[0].request
    layout = options.folder / "table.toml"
    layout.write_text(layout_text(request))
    streams = [camera.stream for camera in cameras]
    frames, found = merged(layout, streams, request)
    truth = list(canvas_truth(request, options.seconds))
    if options.picture:
        draw(options.picture, request, streams, frames, truth, tuple(options.span))
    result = score(truth, frames, found, request)
    for title, figure in result.rows():
        print(f"{title:44}{figure:>14}")
    if options.wrong:
        print(*result.wrong, sep="\n")
    return 0


def make(camera: Camera) -> None:
    """Calibrate the camera, and write what its node publishes."""
    cv2.setNumThreads(1)
    if not exists(camera.profile):
        command = (sys.executable, "-m", "halo_service.app.cli", "calibrate")
        names = ("--source", camera.source, "--profile", str(camera.profile))
        subprocess.run([*command, *names], check=True, capture_output=True)
    if camera.stream.exists():
        return
    profile, node = load(camera.profile), f"camera-{camera.number}"
    with appearing(camera.stream) as file:
        for line in node_stream(camera.request, profile, Settings(), node, camera.seconds):
            file.write(json.dumps(line).encode() + b"\n")


if __name__ == "__main__":
    sys.exit(main())
