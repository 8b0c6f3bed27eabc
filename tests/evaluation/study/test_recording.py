"""Kept frames stand for the full ones: the sensing makes the same of both."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.evaluation.study.recording import (
    Capture,
    Kept,
    keep,
    load,
    reach_of,
    restore,
    save,
)
from halo_service.evaluation.study.sense import Once, Remembered, together
from halo_service.profile import Profile
from halo_service.runtime.method import OURS
from halo_service.settings import Settings
from halo_service.values import Frame, Hand, Pointer, Side, TouchFrame
from halo_service.virtual.offline import Take
from halo_service.virtual.sim_url import parse_sim_url

SECONDS = 8.2
"""Of pointing: three touches, the last one until 7.9 s."""


@dataclass(frozen=True)
class Both:
    """The same take, sensed in full and out of what was kept of it."""

    full: tuple[TouchFrame, ...]
    kept: tuple[TouchFrame, ...]


@pytest.fixture(scope="module")
def both() -> Both:
    settings = Settings()
    request = parse_sim_url("sim:pointing?seed=205&material=wood")
    profile = virtual_profile(request.room, settings)
    take = Take(request, SECONDS, colour_times=2)
    captures: list[Capture] = []
    reach = reach_of(profile.surface, take.camera)
    with closing(HandDetector(take.camera, profile, settings.tracking)) as eyes:
        look = Once(eyes.look)

        def drawn() -> Iterator[Frame]:
            for frame, _ in take:
                if frame is not None:
                    captures.append(keep(frame, look(frame), profile.background, reach))
                    yield frame

        full = together(drawn(), take.camera, look, [OURS], {"ours": profile}, settings.sensing)
    kept = Kept(tuple(captures), (), ())
    return Both(full["ours"], _again(kept, profile, settings))


def _again(kept: Kept, profile: Profile, settings: Settings) -> tuple[TouchFrame, ...]:
    frames = (restore(capture, profile.background)[0] for capture in kept.captures)
    told = together(
        frames, profile.camera, Remembered(kept), [OURS], {"ours": profile}, settings.sensing
    )
    return told["ours"]


@pytest.mark.slow
def test_the_same_touches_come_of_both(both: Both) -> None:
    full, kept = ([_events(frame) for frame in frames] for frames in (both.full, both.kept))
    assert kept == full
    downs = [kind for frame in full for kind, _ in frame if kind == "down"]
    assert len(downs) >= 3


@pytest.mark.slow
def test_the_same_pointers_with_the_same_values_come_of_both(both: Both) -> None:
    pairs: list[tuple[Pointer, Pointer]] = []
    for full, kept in zip(both.full, both.kept, strict=True):
        assert [p.id for p in full.pointers] == [p.id for p in kept.pointers]
        pairs += zip(full.pointers, kept.pointers, strict=True)
    assert len(pairs) > 100
    for name, most in (("x_mm", 0.05), ("y_mm", 0.05), ("hover_mm", 0.05), ("pressure", 0.005)):
        off = [abs(getattr(a, name) - getattr(b, name)) for a, b in pairs]
        print(f"{name}: median {np.median(off):.4f}, p99 {np.percentile(off, 99.0):.4f}")
        assert np.percentile(off, 99.0) <= most, name


def test_a_take_reads_back_as_it_was_written(tmp_path: Path) -> None:
    hand = Hand(Side.LEFT, np.arange(42, dtype=np.float32).reshape(21, 2).astype(np.float64), 0.5)
    captures = (
        Capture(7, (0, 0, 0, 0), b"", np.array([[500, 0]], np.uint16), ()),
        Capture(9, (1, 2, 3, 4), b"xy", np.array([[501, 499]], np.uint16), (hand,)),
    )
    truth, script = ({"time_us": 7, "fingers": []},), ({"step": "hover"},)
    save(tmp_path / "a" / "take.npz", Kept(captures, truth, script), "so")
    kept = load(tmp_path / "a" / "take.npz")
    assert (kept.truth, kept.script) == (truth, script)
    for before, after in zip(captures, kept.captures, strict=True):
        for name in ("time_us", "box", "png"):
            assert getattr(before, name) == getattr(after, name), name
        assert np.array_equal(before.lattice, after.lattice)
    assert kept.captures[0].hands == ()
    (seen,) = kept.captures[1].hands
    assert (seen.side, seen.confidence) == (hand.side, hand.confidence)
    assert np.array_equal(seen.landmarks_px, hand.landmarks_px)


def _events(frame: TouchFrame) -> list[tuple[str, int]]:
    return [(event.kind, event.id) for event in frame.events]
