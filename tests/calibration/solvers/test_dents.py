"""Smooth curves over place and pitch level a dent to less than a per cent."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from halo_calibration.solvers.dents import LEAST_SAMPLES, by_pitch, by_place, top_by_place

Floats = NDArray[np.float64]
X_MM, Y_MM = np.linspace(-20.0, 320.0, 24), np.linspace(-20.0, 220.0, 17)
PITCH_DEG = np.linspace(15.0, 75.0, 9)
AT = (150.0, 100.0)


def place_truth(x_mm: Floats, y_mm: Floats) -> Floats:
    """A slope, and a fall towards the edges."""
    x, y = (x_mm - AT[0]) / 150.0, (y_mm - AT[1]) / 100.0
    return np.asarray((1.0 + 0.05 * x - 0.03 * y) * (1.0 - 0.15 * x**2 - 0.05 * y**2))


def pitch_truth(pitch_deg: Floats) -> Floats:
    return np.asarray(1.0 - 0.05 * ((pitch_deg - 45.0) / 15.0) ** 2)


def swept(strength: Floats, x_mm: Floats, y_mm: Floats, pitch_deg: Floats) -> Floats:
    """Samples with a per cent of noise; every twentieth is misread, every tenth hidden."""
    rng = np.random.default_rng(5)
    dent = 30.0 * strength * rng.normal(1.0, 0.01, len(strength))
    dent[::20] *= 0.4
    dent[5::10] = np.nan
    nothing = np.zeros(len(dent))
    return np.column_stack([x_mm, y_mm, pitch_deg, nothing, nothing + 2000.0, dent])


@pytest.fixture(scope="module")
def sweep() -> Floats:
    rng = np.random.default_rng(4)
    x, y = rng.uniform(25.0, 275.0, 600), rng.uniform(25.0, 175.0, 600)
    return swept(place_truth(x, y), x, y, np.full(600, 45.0))


@pytest.fixture(scope="module")
def pilots() -> Floats:
    rng = np.random.default_rng(6)
    x, y = rng.uniform(-125.0, 125.0, 2000), rng.uniform(-75.0, 75.0, 2000)
    pitch = np.repeat([15.0, 30.0, 45.0, 60.0, 75.0], 400) + rng.normal(0.0, 3.0, 2000)
    both = place_truth(x + AT[0], y + AT[1]) * pitch_truth(np.clip(pitch, 30.0, 60.0))
    return swept(both, x, y, pitch)


def test_the_dent_is_one_where_the_states_were_held_and_true_over_the_swept_area(
    sweep: Floats,
) -> None:
    grid = by_place(sweep, X_MM, Y_MM, AT).strength
    inside = np.ix_((X_MM > 25.0) & (X_MM < 275.0), (Y_MM > 25.0) & (Y_MM < 175.0))
    true = place_truth(X_MM[:, None], Y_MM[None, :])
    assert grid[inside] == pytest.approx(true[inside], rel=0.01)
    assert by_place(sweep, np.array([150.0]), np.array([100.0]), AT).strength == pytest.approx(1.0)


def test_beyond_the_swept_area_its_edge_goes_on(sweep: Floats) -> None:
    grid = by_place(sweep, np.array([-20.0, 10.0, 25.0]), np.array([100.0]), AT).strength
    assert grid[0] == grid[1] == pytest.approx(grid[2], rel=0.01)


def test_a_dent_that_is_four_times_as_deep_at_one_end_is_learned_without_a_limit() -> None:
    rng = np.random.default_rng(7)
    x, y = rng.uniform(5.0, 295.0, 600), rng.uniform(5.0, 195.0, 600)
    true = np.exp((x - AT[0]) / 140.0 * np.log(4.0))
    ends = np.array([10.0, 290.0])
    read = by_place(swept(true, x, y, np.full(600, 45.0)), ends, np.array([100.0]), AT)
    assert read.strength[:, 0] == pytest.approx([0.25, 4.0], rel=0.03)


def test_a_corner_without_samples_stays_close_to_its_neighbours() -> None:
    rng = np.random.default_rng(8)
    x, y = rng.uniform(5.0, 295.0, 600), rng.uniform(5.0, 195.0, 600)
    swept_part = (x > 200.0) | (y > 120.0)
    samples = swept(place_truth(x, y), x, y, np.full(600, 45.0))[swept_part]
    samples[:, 5] *= rng.normal(1.0, 0.1, len(samples))
    corner = by_place(samples, np.array([20.0]), np.array([20.0]), AT)
    true = place_truth(np.array([20.0]), np.array([20.0]))
    assert corner.strength[0] == pytest.approx(true, rel=0.2)
    middle = by_place(samples, np.array([250.0]), np.array([100.0]), AT)
    assert corner.deviation[0] > middle.deviation[0] > 0.08


def test_an_upper_side_that_reads_higher_at_one_edge_is_learned_with_its_deviation() -> None:
    """As where the camera looks along the finger: 24 mm over the surface, a millimetre of noise."""
    rng = np.random.default_rng(9)
    x, y = rng.uniform(5.0, 295.0, 600), rng.uniform(5.0, 195.0, 600)
    top_mm = 8.0 + 24.0 * (y / 200.0) ** 2 + rng.normal(0.0, 1.0, 600)
    top_mm[::20] += 40.0  # misread
    top_mm[5::10] = np.nan
    samples = np.column_stack([*(np.ones((8, 600))), top_mm])
    samples[:, 0], samples[:, 1] = x, y
    grid = top_by_place(samples, np.array([50.0, 250.0]), np.array([20.0, 100.0, 180.0]), AT)
    assert grid is not None
    higher_mm, deviation_mm = grid
    true = 24.0 * (np.array([20.0, 100.0, 180.0]) / 200.0) ** 2 - 6.0
    assert higher_mm == pytest.approx(np.array([true, true]), abs=0.8)
    assert np.all((deviation_mm > 0.8) & (deviation_mm < 2.0))


def test_too_few_upper_sides_say_nothing() -> None:
    samples = np.ones((LEAST_SAMPLES // 2, 9))
    assert top_by_place(samples, X_MM, Y_MM, AT) is None


def test_pitch_and_place_are_separated_within_the_wedges(pilots: Floats) -> None:
    curve = by_pitch(pilots, PITCH_DEG, 45.0)
    assert curve == pytest.approx(pitch_truth(np.clip(PITCH_DEG, 30.0, 60.0)), abs=0.006)
    assert by_pitch(pilots, np.array([35.0]), 35.0) == pytest.approx(1.0)


def test_too_few_samples_correct_nothing(sweep: Floats) -> None:
    few = sweep[: LEAST_SAMPLES // 2]
    assert np.all(by_place(few, X_MM, Y_MM, AT).strength == 1.0)
    assert np.all(by_pitch(few, PITCH_DEG, 45.0) == 1.0)
