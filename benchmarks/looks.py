"""Does the hand model see enough? The same touches with few looks as with one at every frame.

    uv run python benchmarks/looks.py [--seconds S] [SIM ...]

Senses the same virtual frames twice, as `halo replay` does: with the hand model at every frame, and
with the frames left out that depth confirms. Prints the share of frames that the model looked at,
its CPU time a frame, and the touches: found, missed, false. Ends with 1 if fewer looks cost more
than one touch in a hundred.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass

os.environ["OMP_NUM_THREADS"] = "1"  # before the imports below: as the service has it

import cv2

from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.evaluation.metrics.touches import score_touches
from halo_service.evaluation.metrics.truth import Line, read_truth
from halo_service.evaluation.study.sense import FrameSequence
from halo_service.profile import Profile
from halo_service.runtime.method import OURS
from halo_service.runtime.pace import paced_by_depth
from halo_service.runtime.replay import replay
from halo_service.sensing import start
from halo_service.settings import Settings
from halo_service.values import Frame, Tracked
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.sim_url import parse_sim_url

SOURCES = (
    *(f"sim:pointing?seed={seed}" for seed in (201, 202, 203)),
    "sim:projector?seed=203", "sim:drumming?seed=202", "sim:drumming?seed=205",
    "sim:typing?seed=203", "sim:typing?seed=8", "sim:chaos?seed=204",
)  # fmt: skip
ALLOWED = 0.01
"""Share of the true touches that fewer looks may lose."""


@dataclass(frozen=True, slots=True)
class Result:
    """One way to look at one recording."""

    looks: float
    cpu_ms: float
    hits: int
    missed: int
    false: int


def main() -> int:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sources", nargs="*", default=SOURCES, metavar="SIM")
    parser.add_argument("--seconds", type=float, default=20.0)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    every, few = 0, 0
    print(f"{'':28} {'':11} looks  CPU a frame  found  missed  false")
    for source in given.sources:
        both = compare(source, given.seconds)
        for name, found in zip(("every frame", "paced"), both, strict=True):
            print(
                f"{source:28} {name:11} {found.looks:5.0%} {found.cpu_ms:9.1f} ms "
                f"{found.hits:6} {found.missed:7} {found.false:6}",
                flush=True,
            )
        every, few = every + both[0].hits, few + both[1].hits
    print(f"touches found: {every} with every frame, {few} paced")
    return int(few < every * (1.0 - ALLOWED))


def compare(source: str, seconds: float) -> tuple[Result, Result]:
    """Sense one recording in both ways."""
    request, settings = parse_sim_url(source), Settings()
    profile = cached_profile(request.room, settings, virtual_profile)
    simulation = SimulatedRecording(request, seconds, colour=False)
    truth: list[Line] = []
    frames: list[Frame] = []
    for frame, lines in simulation:
        truth += lines
        frames += [] if frame is None else [frame]
    every, paced = (sense(frames, truth, profile, settings, paced=paced) for paced in (False, True))
    return every, paced


def sense(
    frames: list[Frame], truth: list[Line], profile: Profile, settings: Settings, *, paced: bool
) -> Result:
    """Sense the frames with a hand model of its own, and score the touches."""
    hands = settings.tracking.max_hands
    looks, cpu_s = 0, 0.0
    with closing(HandDetector(profile.camera, profile, settings.tracking)) as detector:

        def look(frame: Frame) -> Tracked:
            nonlocal looks
            looks += 1
            return detector.detect(frame)

        detect: Callable[[Frame], Tracked] = paced_by_depth(look, profile, hands) if paced else look

        def timed(frame: Frame) -> Tracked:
            nonlocal cpu_s
            began_s = time.process_time()
            tracked = detect(frame)
            cpu_s += time.process_time() - began_s
            return tracked

        source = FrameSequence(frames, profile.camera)
        state = start(profile, settings.sensing)
        published = tuple(replay(source, timed, OURS, state))
    touches = score_touches(published, read_truth(truth, profile.surface))
    return Result(
        looks / len(frames),
        1000.0 * cpu_s / len(frames),
        len(touches.hits),
        len(touches.missed),
        len(touches.doubled) + len(touches.outside) + len(touches.ghosts),
    )


if __name__ == "__main__":
    raise SystemExit(main())
