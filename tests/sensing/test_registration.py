"""How far a hand moved, from height maps that say so."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from halo_service.profile import Background
from halo_service.sensing.registration import HeightMap, height_map, path_px, shift_px

SURFACE_MM, FRAME_US = 500.0, 33_333
TIP = 300.0, 250.0


def hand(
    tip: tuple[float, float] = TIP, lifted_mm: float = 0.0, turned: float = 0.0
) -> NDArray[np.float32]:
    """A pointing finger and two folded ones, 15 mm high; a pixel is a millimetre."""
    y, x = np.mgrid[:576, :640].astype(np.float32)
    y, x = y - np.float32(tip[1]), x - np.float32(tip[0])
    x = x + np.float32(turned) * y
    finger = (np.hypot(x, np.minimum(y - 8.0, 0.0)) < 8.0) & (y > -1.0)
    folded = (np.hypot(x - 30.0, np.minimum(y - 40.0, 0.0)) < 20.0) & (y > 20.0)
    depth = np.full(x.shape, SURFACE_MM, np.float32)
    depth[finger | folded] -= np.float32(15.0 + lifted_mm)
    return depth


def seen(
    depth: NDArray[np.float32], frame: int, noise_mm: float = 1.0, drift_mm: float = 0.0
) -> HeightMap:
    rng = np.random.default_rng(frame)
    noisy = depth + rng.normal(0.0, noise_mm, depth.shape).astype(np.float32)
    empty = Background(
        np.full(depth.shape, SURFACE_MM, np.float32),
        np.ones(depth.shape, np.float32),
        np.ones(depth.shape, np.bool_),
    )
    return height_map(frame * FRAME_US, noisy + np.float32(drift_mm), empty, drift_mm, 1.0)


@pytest.mark.parametrize("way", [(0.0, 0.0), (4.0, -7.5), (-31.0, 12.0), (44.0, 44.0)])
def test_a_hand_is_found_again_to_a_millimetre(way: tuple[float, float]) -> None:
    moved = hand((TIP[0] + way[0], TIP[1] + way[1]))
    assert shift_px(seen(hand(), 0), seen(moved, 1), TIP) == pytest.approx(way, abs=1.2)


@pytest.mark.parametrize(
    "changed", [{"lifted_mm": 8.0}, {"turned": 0.1}, {"lifted_mm": -6.0, "turned": -0.05}]
)
def test_a_hand_that_rises_and_turns_is_the_same(changed: dict[str, float]) -> None:
    way = 15.0, -9.0
    moved = hand((TIP[0] + way[0], TIP[1] + way[1]), **changed)
    assert shift_px(seen(hand(), 0), seen(moved, 1), TIP) == pytest.approx(way, abs=2.5)


def test_a_device_that_drifts_moves_no_hand() -> None:
    now = seen(hand(), 1, drift_mm=6.0)
    assert shift_px(seen(hand(), 0), now, TIP) == pytest.approx((0.0, 0.0), abs=0.8)


def test_nothing_is_found_where_nothing_is_or_where_it_is_gone() -> None:
    empty = np.full((576, 640), SURFACE_MM, np.float32)
    assert shift_px(seen(empty, 0), seen(hand(), 1), TIP) is None
    assert shift_px(seen(hand(), 0), seen(empty, 1), TIP) is None
    assert shift_px(seen(hand(), 0), seen(hand((TIP[0] + 200.0, TIP[1])), 1), TIP) is None


@pytest.mark.parametrize("place", [(-900.0, 100.0), (100.0, 9_000.0), (1e9, -1e9)])
def test_nothing_is_outside_the_image(place: tuple[float, float]) -> None:
    assert shift_px(seen(hand(), 0), seen(hand(), 1), place) is None


def test_a_hand_at_the_image_edge_is_found_again() -> None:
    at, now = (620.0, 540.0), (612.0, 534.0)
    way = shift_px(seen(hand(at), 0), seen(hand(now), 1), at)
    assert way == pytest.approx((-8.0, -6.0), abs=2.5)


def test_a_path_is_the_sum_of_its_frames() -> None:
    maps = [seen(hand((TIP[0] + 30.0 * n, TIP[1])), n) for n in range(4)]
    assert path_px(maps, TIP, 0) == pytest.approx((90.0, 0.0), abs=2.0)
    at_2 = TIP[0] + 60.0, TIP[1]
    assert path_px(maps, at_2, 2 * FRAME_US) == pytest.approx((30.0, 0.0), abs=1.5)
    assert path_px(maps, TIP, 3 * FRAME_US) == (0.0, 0.0)
    assert path_px(maps[1:], TIP, 0) is None  # older than the oldest
    assert path_px((), TIP, 0) is None


def test_coarser_images_give_the_same_millimetres() -> None:
    """Binned modes and higher cameras have fewer pixels a millimetre."""
    whole = seen(hand(), 0, noise_mm=0.0)
    half = Background(
        np.full((288, 320), SURFACE_MM, np.float32),
        np.ones((288, 320), np.float32),
        np.ones((288, 320), np.bool_),
    )
    maps = [
        height_map(n, hand((TIP[0] + 16.0 * n, TIP[1]))[::2, ::2], half, 0.0, 0.5) for n in range(2)
    ]
    assert maps[0].cell_px < whole.cell_px
    way = shift_px(maps[0], maps[1], (TIP[0] / 2.0, TIP[1] / 2.0))
    assert way == pytest.approx((8.0, 0.0), abs=1.0)
