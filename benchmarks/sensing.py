"""The cost of sensing a frame by its number of fingers: `python benchmarks/sensing.py FOLDER`.

FOLDER holds one user's recordings, from `halo evaluate --cache`: `pointing` shows one finger,
`ten-fingers` two or, if every finger is a pointer, ten. It prints the CPU time of a frame, and how
many full-frame differences to the background the same machine computes in that time.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from statistics import median
from typing import TypeVar

import cv2

from halo_service.evaluation.study.calibrate import by_script
from halo_service.evaluation.study.plan import CALIBRATION, user_of
from halo_service.evaluation.study.recording import load, restored
from halo_service.evaluation.study.simulate import background_of
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.sensing import SensingSettings, start, step
from halo_service.sensing.background import excess_depth
from halo_service.sensing.detections import Fingers
from halo_service.values import Frame, Tracked
from halo_service.virtual.sim_url import parse_sim_url

T = TypeVar("T")
FRAMES = 300
CASES: tuple[tuple[str, Fingers, int], ...] = (
    ("pointing", "index", 1),
    ("ten-fingers", "index", 2),
    ("ten-fingers", "all", 10),
)
"""A recording, which fingers are pointers, and their number."""


def main() -> int:
    """Print one line a case."""
    folder = Path(sys.argv[1])
    cv2.setNumThreads(1)  # as `halo serve` does
    calibration = load(folder / "calibration.npz")
    background = background_of(calibration)
    profile = by_script(calibration, _camera(folder), background, SensingSettings())
    for task, fingers, count in CASES:
        frames = list(islice(restored(load(folder / f"{task}.npz"), background), FRAMES))
        sensing, difference = costs(profile, SensingSettings(fingers=fingers), frames, count)
        print(
            f"{count:2} fingers  {1e3 * sensing:5.2f} ms a frame  {1e3 * sensing / count:.2f} ms a "
            f"finger  {sensing / difference:5.2f} full-frame differences",
            flush=True,
        )
    return 0


def _camera(folder: Path) -> Camera:
    """Return the camera of a user's folder, as `User.name` names it."""
    user = user_of(folder.name)
    if user is None:
        raise SystemExit(f"{folder} is not a user's folder; name one that --cache wrote")
    return parse_sim_url(user.source(CALIBRATION)).room.camera()


def costs(
    profile: Profile, settings: SensingSettings, frames: list[tuple[Frame, Tracked]], count: int
) -> tuple[float, float]:
    """Return the median s of a frame with so many pointers, and of a full-frame difference."""
    state, late = start(profile, settings), None
    steps, differences = [], []
    for frame, tracked in frames:
        (touch_frame, state), seconds = timed(lambda s=state, f=frame, t=late: step(s, f, t))
        late = tracked
        if len(touch_frame.pointers) == count:
            steps.append(seconds)
            _, seconds = timed(lambda f=frame: excess_depth(f.depth, profile.background))
            differences.append(seconds)
    if not steps:
        raise SystemExit(f"no frame of the recording shows {count} fingers")
    return median(steps), median(differences)


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """Run `work`; return its result and its CPU time in this thread, s."""
    began = time.thread_time()
    done = work()
    return done, time.thread_time() - began


if __name__ == "__main__":
    raise SystemExit(main())
