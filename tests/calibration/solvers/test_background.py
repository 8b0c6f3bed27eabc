"""The background is refused when it is no empty, quiet surface."""

from __future__ import annotations

import numpy as np
import pytest

from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.background import average, halo_threshold, solve_background

SHAPE = (96, 120)


def quiet(count: int = 60, noise_mm: float = 1.0) -> list[np.ndarray]:
    rng = np.random.default_rng(1)
    return [np.rint(rng.normal(500.0, noise_mm, SHAPE)).astype(np.uint16) for _ in range(count)]


def test_mean_noise_and_validity_are_those_of_the_frames() -> None:
    frames = quiet()
    for n, frame in enumerate(frames):
        frame[0, 0] = 0 if n < 16 else 500  # 44 good frames of 60
        frame[0, 1] = 0 if n < 15 else 500
    background = solve_background(frames)
    assert background.mean_mm[1:].mean() == pytest.approx(500.0, abs=0.1)
    assert background.noise_mm[1:].mean() == pytest.approx(1.0, abs=0.1)
    assert background.valid[0, :2].tolist() == [False, True]
    assert background.valid[1:].all()


def test_45_frames_suffice_and_fewer_are_dropped_frames() -> None:
    solve_background(quiet(45))
    with pytest.raises(CalibrationError, match=r"only 44 of the 60 frames .* dropped frames"):
        solve_background(quiet(44))


@pytest.mark.parametrize(
    ("rows", "columns", "where"),
    [
        (slice(0, 24), slice(0, 32), "far left"),
        (slice(70, 96), slice(88, 120), "near right"),
        (slice(40, 60), slice(48, 72), "in the middle"),
    ],
)
@pytest.mark.parametrize("when", [slice(0, 25), slice(25, 35), slice(35, 60)])
def test_what_moved_is_refused_and_its_place_is_said(
    rows: slice, columns: slice, where: str, when: slice
) -> None:
    frames = quiet()
    for frame in frames[when]:
        frame[rows, columns] = 440
    with pytest.raises(CalibrationError, match=f"something moved .*{where}"):
        solve_background(frames)


def test_what_is_measured_at_one_end_only_has_moved() -> None:
    frames = quiet()
    for frame in frames[40:]:
        frame[:24, :32] = 0
    with pytest.raises(CalibrationError, match=r"something moved .*far left"):
        solve_background(frames)


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_a_dark_rim_that_flickers_has_not_moved(share: float) -> None:
    frames, rng = quiet(), np.random.default_rng(2)
    for frame in frames:
        frame[:32][rng.random((32, SHAPE[1])) > share] = 0
    solve_background(frames)


def test_a_device_that_warms_up_has_not_moved() -> None:
    frames = quiet()
    for n, frame in enumerate(frames):
        frame += np.uint16(n // 30)
    solve_background(frames)


@pytest.mark.parametrize(("noise_mm", "threshold"), [(0.1, 4.0), (1.2, 6.0), (9.0, 10.0)])
def test_the_halo_threshold_follows_the_noise_within_bounds(
    noise_mm: float, threshold: float
) -> None:
    frames = [frame * 1.0 for frame in quiet(60, noise_mm)]
    assert halo_threshold(average(frames)) == pytest.approx(threshold, abs=0.4)
