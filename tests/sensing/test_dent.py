"""The depth of a dent is read from its visible part, though the finger is found a little off."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from halo_service.profile import Profile
from halo_service.sensing import start, step
from halo_service.sensing.dent import BELL_PX, dent_under
from halo_service.sensing.segmentation import Segmentation, segment
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Finger, Fingertip, Frame, Side, Tracked

PAD_PX = (320.0, 295.0)
"""Under the middle of a round tip that ends at 288."""
FINGER_PX = 8.0
"""Half its breadth."""
DEEP_MM = 20.0
ROWS, COLUMNS = np.mgrid[:576, :640]


def excess(deep_mm: float = DEEP_MM, beside_mm: float | None = None) -> NDArray[np.float32]:
    """A finger that points up the image over a dent; 12 px to its right something else."""
    away = np.hypot(COLUMNS - PAD_PX[0], ROWS - PAD_PX[1])
    seen = deep_mm * np.exp(-((away / BELL_PX) ** 2))
    if beside_mm is not None:
        seen[PAD_PX[0] + 12 < COLUMNS] = beside_mm
    below = (np.abs(COLUMNS - PAD_PX[0]) < FINGER_PX) & (PAD_PX[1] < ROWS)
    seen[below | (away < FINGER_PX)] = -14.0
    return seen.astype(np.float32)


def segmentation(seen: NDArray[np.float32]) -> Segmentation:
    return segment(seen, SensingSettings(), 8.0)


def found(off_px: tuple[float, float] = (0.0, 0.0), at: tuple[float, float] = PAD_PX) -> Fingertip:
    """The finger, found so far off: a pixel is a millimetre."""
    x, y = at[0] + off_px[0], at[1] + off_px[1]
    pad_mm = (x - 319.5 + 150.0, y - 287.5 + 100.0)
    tip, distal = (x, y - 7.0), (x, y + 18.0)
    return Fingertip(
        Side.RIGHT, Finger.INDEX, tip, distal, pad_mm, (0, 0, 500), 14.0, 45.0, 0.0, 1.0
    )


@pytest.mark.parametrize("deep_mm", [40.0, 20.0, 5.0])
@pytest.mark.parametrize("off_px", [(0.0, 2.0), (0.0, 0.5), (0.0, 3.5), (1.0, 2.0), (-1.0, 2.0)])
def test_a_finger_found_a_little_off_reads_as_deep(
    profile: Profile, deep_mm: float, off_px: tuple[float, float]
) -> None:
    read = dent_under(segmentation(excess(deep_mm)), found(off_px), profile)
    assert read == pytest.approx(deep_mm, rel=0.04)


@pytest.mark.parametrize("beside_mm", [-30.0, -4.5, 0.0])
def test_what_covers_part_of_the_dent_or_is_unmeasured_is_left_out(
    profile: Profile, beside_mm: float
) -> None:
    read = dent_under(segmentation(excess(beside_mm=beside_mm)), found((0.0, 2.0)), profile)
    assert read == pytest.approx(DEEP_MM, rel=0.03)


@pytest.mark.parametrize("off_px", [(0.0, 1.0), (0.0, 3.5)])
def test_skin_that_reads_as_the_empty_surface_does_is_left_out(
    profile: Profile, off_px: tuple[float, float]
) -> None:
    deep_mm, seen = 40.0, excess(40.0)
    away = np.hypot(COLUMNS - PAD_PX[0], ROWS - PAD_PX[1])
    seen[(away > FINGER_PX) & (away < FINGER_PX + 3) & (PAD_PX[0] < COLUMNS)] = 1.0
    read = dent_under(segmentation(seen), found(off_px), profile)
    assert read == pytest.approx(deep_mm, rel=0.08)


def test_an_undented_surface_reads_next_to_nothing(profile: Profile) -> None:
    noise = np.random.default_rng(1).normal(0.0, 1.5, (576, 640)).astype(np.float32)
    read = dent_under(segmentation(excess(0.0) + noise), found((0.0, 2.0)), profile)
    assert abs(read) < 0.5


@pytest.mark.parametrize("at", [PAD_PX, (-90.0, 288.0), (320.0, 900.0)])
def test_a_hidden_dent_is_not_guessed(profile: Profile, at: tuple[float, float]) -> None:
    hidden = np.full((576, 640), -40.0, np.float32)
    assert math.isnan(dent_under(segmentation(hidden), found(at=at), profile))


@pytest.mark.parametrize("hidden_px", [12.0, 14.0])
def test_a_rim_of_a_dent_gives_no_depth(profile: Profile, hidden_px: float) -> None:
    seen = excess()
    seen[np.hypot(COLUMNS - PAD_PX[0], ROWS - PAD_PX[1]) < hidden_px] = -40.0
    assert math.isnan(dent_under(segmentation(seen), found(), profile))


@pytest.fixture
def held(profile: Profile) -> Profile:
    """The four states as dents of 10, 18, 24 and 30 mm; their sums are out of reach."""
    assert profile.touch is not None
    depths = {"hover": 10.0, "subtle": 18.0, "touch": 24.0, "pressure": 30.0}
    states = {
        name: replace(getattr(profile.touch, name), deep_mm=deep_mm, signal=1e5 * deep_mm)
        for name, deep_mm in depths.items()
    }
    return replace(profile, touch=replace(profile.touch, **states))


@pytest.mark.parametrize("beside_mm", [None, -14.0], ids=["free", "half hidden by a neighbour"])
def test_a_tap_is_detected_by_its_dent(
    held: Profile, see: Callable[..., Tracked], beside_mm: float | None
) -> None:
    state, frames = start(held, SensingSettings()), []
    for n, deep_mm in enumerate([10, 10, 10, 24, 24, 24, 10, 10, 10]):
        depth = np.rint(500.0 + excess(deep_mm, beside_mm)).astype(np.uint16)
        frame = Frame(n * 33_333, depth, np.full((576, 640), 1000, np.uint16))
        seen, state = step(state, frame, see(time_us=n * 33_333))
        frames.append(seen)
    assert [(n, e.kind) for n, frame in enumerate(frames) for e in frame.events] == [
        (3, "down"),
        (7, "up"),
    ]
