"""Readings of a halo grow with it, whatever its shape, its place and the camera's height."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from halo_service.profile import Profile
from halo_service.sensing import start, step
from halo_service.sensing.readings import readings
from halo_service.sensing.segmentation import Segmentation, segment
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Finger, Fingertip, Frame, Side, Tracked
from tests.drawn import DrawnTable

PAD_PX = (320.0, 295.0)
"""Under the middle of a round tip that ends at 288."""
FINGER_PX = 8.0
"""Half its breadth."""
DEPTH_MM = 20.0
ROWS, COLUMNS = np.mgrid[:576, :640]
OFF_PX = [(0.0, 2.0), (0.0, -1.5), (1.0, 0.5), (-1.0, 1.0)]


def bell(right: NDArray[np.float64], down: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.exp(-(right**2 + down**2) / 100.0))


HALOS: dict[str, Callable[..., NDArray[np.float64]]] = {
    "bell": bell,
    "towards the palm": lambda right, down: bell(right, down - 5.0),
    "drawn out": lambda right, down: bell(right, down / 1.8),
    "lopsided": lambda right, down: bell(right, down) * (1.0 + 0.3 * np.tanh(right / 10.0)),
    "flat": lambda right, down: np.where(np.hypot(right, down) < 16.0, 1.0, 1e-3),
}


def excess(
    depth_mm: float = DEPTH_MM, shape: Callable[..., NDArray[np.float64]] = bell
) -> NDArray[np.float32]:
    """A finger that points up the image over a halo."""
    right, down = COLUMNS - PAD_PX[0], ROWS - PAD_PX[1]
    seen = depth_mm * shape(right, down)
    below = (np.abs(right) < FINGER_PX) & (down > 0)
    seen[below | (np.hypot(right, down) < FINGER_PX)] = -14.0
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


@pytest.mark.parametrize("shape", HALOS.values(), ids=HALOS)
def test_all_readings_grow_with_a_halo_of_any_shape(
    profile: Profile, shape: Callable[..., NDArray[np.float64]]
) -> None:
    read = [
        readings(segmentation(excess(deep, shape)), found(), profile) for deep in (10, 20, 24, 30)
    ]
    assert np.all(np.diff(read, axis=0) > 0.0)


@pytest.mark.parametrize("shape", HALOS.values(), ids=HALOS)
@pytest.mark.parametrize("off_px", OFF_PX)
def test_a_finger_found_a_little_off_reads_as_deep(
    profile: Profile, shape: Callable[..., NDArray[np.float64]], off_px: tuple[float, float]
) -> None:
    scene = segmentation(excess(DEPTH_MM, shape))
    true, read = (readings(scene, found(off), profile) for off in ((0.0, 0.0), off_px))
    assert read[1:3] == pytest.approx(true[1:3], rel=0.06)


@pytest.mark.parametrize("shape", [HALOS["bell"], HALOS["drawn out"], HALOS["flat"]])
def test_a_halo_that_another_finger_half_hides_reads_as_deep(
    profile: Profile, shape: Callable[..., NDArray[np.float64]]
) -> None:
    scene = segmentation(excess(DEPTH_MM, shape))
    half = replace(scene, free=scene.free & (PAD_PX[0] > COLUMNS))
    whole, read = (readings(each, found(), profile) for each in (scene, half))
    assert read[1:3] == pytest.approx(whole[1:3], rel=0.1)


@pytest.mark.parametrize(("hidden_px", "read"), [(0.0, True), (6.0, True), (16.0, False)])
def test_a_halo_that_other_fingers_hide_nearly_is_not_read(
    profile: Profile, hidden_px: float, read: bool
) -> None:
    """All that shows is its far rim."""
    scene = segmentation(excess())
    rim = replace(scene, free=scene.free & (PAD_PX[0] - hidden_px > COLUMNS))
    assert np.isfinite(readings(rim, found(), profile)[1:]).all() == read


def test_skin_that_reads_as_the_empty_surface_does_is_left_out(profile: Profile) -> None:
    seen = excess(40.0)
    true = readings(segmentation(seen), found(), profile)
    away = np.hypot(COLUMNS - PAD_PX[0], ROWS - PAD_PX[1])
    seen[(away > FINGER_PX) & (away < FINGER_PX + 2) & (PAD_PX[0] < COLUMNS)] = 1.0
    read = readings(segmentation(seen), found(), profile)
    assert read[1] == pytest.approx(true[1], rel=0.15)


def test_noise_on_an_even_surface_reads_next_to_nothing(profile: Profile) -> None:
    noise_mm = 1.5
    background = replace(
        profile.background, noise_mm=np.full((576, 640), noise_mm, dtype=np.float32)
    )
    noise = np.random.default_rng(1).normal(0.0, noise_mm, (576, 640)).astype(np.float32)
    seen = segmentation(excess(0.0) + noise)
    read = readings(seen, found(), replace(profile, background=background))
    assert np.abs(read[1:]).max() < 0.5


@pytest.mark.parametrize("at", [PAD_PX, (-90.0, 288.0), (320.0, 900.0)])
def test_a_hidden_halo_is_not_guessed(profile: Profile, at: tuple[float, float]) -> None:
    hidden = np.full((576, 640), -40.0, np.float32)
    read = readings(segmentation(hidden), found(at=at), profile)
    assert all(math.isnan(each) for each in read[1:])


def test_a_halo_reads_alike_from_every_height_and_through_every_lens(table: DrawnTable) -> None:
    middle_mm = (table.surface_mm[0] / 2.0 + 0.5, table.surface_mm[1] / 2.0 + 0.5)
    pixels = np.stack(np.meshgrid(*map(np.arange, reversed(table.shape))), axis=-1)
    places = (pixels.reshape(-1, 2) - table.px(middle_mm)) / table.px_per_mm
    right, down = places.T.reshape(2, *table.shape)
    seen = DEPTH_MM * bell(right, down)
    seen[(np.hypot(right, down) < 8.0) | ((np.abs(right) < 8.0) & (down > 0.0))] = -14.0
    tip, joint = (table.px((middle_mm[0], middle_mm[1] + mm)) for mm in (-7.0, 18.0))
    finger = replace(found(), tip_px=tip, distal_px=joint, pad_mm=middle_mm)
    read = readings(segmentation(seen.astype(np.float32)), finger, table.profile)
    assert read[1:] == pytest.approx((4.3, 3.2, 3.0), rel=0.25)


@pytest.fixture
def held(profile: Profile) -> Profile:
    """The four states as bells of 10, 18, 24 and 30 mm; their sums are out of reach."""
    assert profile.touch is not None
    depths = {"hover": 10.0, "subtle": 18.0, "touch": 24.0, "pressure": 30.0}
    states = {}
    for name, depth_mm in depths.items():
        _, *read = readings(segmentation(excess(depth_mm)), found(), profile)
        states[name] = replace(
            getattr(profile.touch, name),
            readings=(1e5 * depth_mm, *read),
            noise=(9e5, 0.1, 0.1, 0.1),
        )
    # 0 means unmeasured; the mean of an empty surface is hardly ever a whole number.
    background = replace(profile.background, mean_mm=profile.background.mean_mm - np.float32(0.01))
    return replace(profile, touch=replace(profile.touch, **states), background=background)


@pytest.mark.parametrize("beside_mm", [None, -14.0], ids=["free", "a neighbour next to it"])
def test_a_tap_is_detected_by_its_depths(
    held: Profile, see: Callable[..., Tracked], beside_mm: float | None
) -> None:
    state, frames = start(held, SensingSettings()), []
    for n, depth_mm in enumerate([10, 10, 10, 24, 24, 24, 10, 10, 10]):
        seen_mm = excess(depth_mm)
        if beside_mm is not None:
            seen_mm[PAD_PX[0] + 12 < COLUMNS] = beside_mm
        depth = np.rint(500.0 + seen_mm).astype(np.uint16)
        frame = Frame(n * 33_333, depth, np.full((576, 640), 1000, np.uint16))
        seen, state = step(state, frame, see(time_us=n * 33_333))
        frames.append(seen)
    assert [(n, e.kind) for n, frame in enumerate(frames) for e in frame.events] == [
        (3, "down"),
        (7, "up"),
    ]
