"""The sensing gives the same for stored frames as for the full ones."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.evaluation.study.recording import (
    StoredFrame,
    StoredRecording,
    load,
    reach_box,
    restored,
    save,
    store,
)
from halo_service.evaluation.study.sense import CachedHands, SharedTracker, sense_all
from halo_service.evaluation.study.simulate import Tracker
from halo_service.profile import Profile
from halo_service.runtime.method import OURS
from halo_service.settings import Settings
from halo_service.values import Frame, Hand, Pointer, Side, TouchFrame
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.sim_url import parse_sim_url
from tests.kind_sensor import KIND_URL

SECONDS = 4.7
"""Of the demo: four touches, the last one until 4.6 s."""


@dataclass(frozen=True)
class Both:
    """The same recording, sensed in full and from what is stored of it."""

    full: tuple[TouchFrame, ...]
    stored: tuple[TouchFrame, ...]


@pytest.fixture(scope="module")
def both() -> Both:
    settings = Settings()
    request = parse_sim_url(f"sim:demo?seed=205&material=wood&{KIND_URL}")
    profile = cached_profile(request.room, settings, virtual_profile)
    simulation = SimulatedRecording(request, SECONDS, colour_times=2)
    frames: list[StoredFrame] = []
    reach = reach_box(profile.surface, simulation.camera)
    with closing(HandDetector(simulation.camera, profile, settings.tracking)) as detector:
        track = SharedTracker(detector.detect)

        def simulated() -> Iterator[Frame]:
            for frame, _ in simulation:
                if frame is not None:
                    frames.append(store(frame, track(frame), profile.background, reach))
                    yield frame

        full = _sensed(simulated(), track, profile, settings)
    recording = StoredRecording(tuple(frames), (), ())
    restored_frames = (frame for frame, _ in restored(recording, profile.background))
    return Both(full, _sensed(restored_frames, CachedHands(recording), profile, settings))


def _sensed(
    frames: Iterator[Frame], track: Tracker, profile: Profile, settings: Settings
) -> tuple[TouchFrame, ...]:
    methods, profiles = [OURS], {"ours": profile}
    return sense_all(frames, profile.camera, track, methods, profiles, settings.sensing)["ours"]


@pytest.mark.slow
def test_both_give_the_same_touches(both: Both) -> None:
    full, stored = ([_events(frame) for frame in frames] for frames in (both.full, both.stored))
    assert stored == full
    downs = [kind for frame in full for kind, _ in frame if kind == "down"]
    assert len(downs) >= 3


@pytest.mark.slow
def test_both_give_the_same_pointers_with_the_same_values(both: Both) -> None:
    pairs: list[tuple[Pointer, Pointer]] = []
    for full, stored in zip(both.full, both.stored, strict=True):
        assert [p.id for p in full.pointers] == [p.id for p in stored.pointers]
        pairs += zip(full.pointers, stored.pointers, strict=True)
    assert len(pairs) > 100
    for name, most in (("x_mm", 0.05), ("y_mm", 0.05), ("hover_mm", 0.05), ("pressure", 0.005)):
        off = [abs(getattr(a, name) - getattr(b, name)) for a, b in pairs]
        print(f"{name}: median {np.median(off):.4f}, p99 {np.percentile(off, 99.0):.4f}")
        assert np.percentile(off, 99.0) <= most, name


def test_a_recording_reads_back_as_it_was_written(tmp_path: Path) -> None:
    hand = Hand(Side.LEFT, np.arange(42, dtype=np.float32).reshape(21, 2).astype(np.float64), 0.5)
    frames = (
        StoredFrame(7, (0, 0, 0, 0), b"", b"", np.array([[500, 0]], np.uint16), ()),
        StoredFrame(
            9, (1, 2, 3, 4), b"xy", b"z", np.array([[501, 499]], np.uint16), (hand,), (hand, hand)
        ),
    )
    truth, script = ({"time_us": 7, "fingers": []},), ({"step": "hover"},)
    save(tmp_path / "a" / "recording.npz", StoredRecording(frames, truth, script), "key")
    again = load(tmp_path / "a" / "recording.npz")
    assert (again.truth, again.script) == (truth, script)
    for before, after in zip(frames, again.frames, strict=True):
        for name in ("time_us", "box", "png", "infrared_png"):
            assert getattr(before, name) == getattr(after, name), name
        assert np.array_equal(before.lattice, after.lattice)
    assert again.frames[0].hands == ()
    assert [len(each.image_hands) for each in again.frames] == [0, 2]
    (found,) = again.frames[1].hands
    assert (found.side, found.confidence) == (hand.side, hand.confidence)
    assert np.array_equal(found.landmarks_px, hand.landmarks_px)


def _events(frame: TouchFrame) -> list[tuple[str, int]]:
    return [(event.kind, event.id) for event in frame.events]
