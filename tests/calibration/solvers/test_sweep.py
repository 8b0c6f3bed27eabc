"""A sweep is judged, and its correction levels the signal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halo_calibration.errors import CalibrationError
from halo_calibration.observe import Observation
from halo_calibration.solvers.correction import (
    Base,
    Model,
    Reference,
    cross_validate,
    solve_correction,
)
from halo_calibration.solvers.sweep import (
    SweepObservations,
    check_sweep,
    coverage,
    covered,
    draw_map,
)
from halo_service.geometry.surface import Surface
from halo_service.profile import Correction
from halo_service.sensing.correction import correct, strength
from halo_service.values import Fingertip, Side

SURFACE = Surface("table", 300.0, 200.0, np.eye(4))
AT = Reference(150.0, 100.0, 45.0, 0.0)


def truth(x_mm: float, y_mm: float, pitch_deg: float, yaw_deg: float) -> float:
    """A signal that varies by place and angle as a real one might."""
    by_place = 1.0 + 0.3 * (x_mm - 150.0) / 150.0 - 0.2 * (y_mm - 100.0) / 100.0
    return 2000.0 * by_place * (1.0 - 0.004 * abs(yaw_deg)) * (0.6 + 0.4 * pitch_deg / 45.0)


def sweep(
    *, x_to: float = 280.0, lifted: int = 0, received: int = 600, pitch_deg: float = 45.0
) -> SweepObservations:
    rng = np.random.default_rng(3)
    seen = []
    for n in range(received):
        row, along = divmod(n, 100)
        x = 20.0 + (x_to - 20.0) * (along if row % 2 == 0 else 99 - along) / 99
        y, yaw = 20.0 + 32.0 * row, 25.0 * np.sin(n / 17.0)
        raw = truth(x, y, pitch_deg, yaw) * rng.normal(1.0, 0.02) * (0.1 if n < lifted else 1.0)
        seen.append(Observation(n, Side.RIGHT, x, y, pitch_deg, float(yaw), 14.0, raw, raw, 5))
    return SweepObservations(600, received, tuple(seen))


def spread(correction: Correction | None) -> float:
    """Variation of a touch's corrected signal over the area and its yaws."""
    signals = []
    for x in np.linspace(25.0, 275.0, 11):
        for y in np.linspace(25.0, 175.0, 7):
            for yaw in (-15.0, 0.0, 15.0):
                tip = Fingertip(
                    Side.RIGHT, 1, (0, 0), (0, 0), (x, y), (0, 0, 0), 14.0, 45.0, yaw, 1.0
                )  # type: ignore[arg-type]
                signals.append(correct(truth(x, y, 45.0, yaw), tip, correction))
    return float(np.std(signals) / np.mean(signals))


@pytest.fixture(scope="module")
def correction() -> Correction:
    return solve_correction(SURFACE, None, check_sweep(sweep(), SURFACE), AT)


def test_a_corrected_touch_varies_at_most_half_as_much_as_the_raw_one(
    correction: Correction,
) -> None:
    samples = check_sweep(sweep(), SURFACE)
    assert spread(correction) < 0.5 * spread(None)
    fit = cross_validate(SURFACE, None, samples)
    assert fit.corrected < 0.5 * fit.raw


def test_the_correction_is_one_where_the_states_were_held(correction: Correction) -> None:
    assert strength(correction, 150.0, 100.0, 45.0, 0.0) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("share", [0.2, 5.0])
def test_a_halo_far_weaker_or_stronger_than_where_the_states_were_held_is_corrected(
    correction: Correction, share: float
) -> None:
    changed = replace(correction, strength=np.full_like(correction.strength, share))
    assert strength(changed, 150.0, 100.0, 45.0, 0.0) == pytest.approx(share)


def test_two_fits_of_the_same_samples_are_equal(correction: Correction) -> None:
    again = solve_correction(SURFACE, None, check_sweep(sweep(), SURFACE), AT)
    np.testing.assert_array_equal(again.strength, correction.strength)


def test_between_the_grids_points_little_is_lost(correction: Correction) -> None:
    samples = check_sweep(sweep(), SURFACE)
    model = Model(SURFACE, None, samples)
    here = model.expect(np.array([[150.0, 100.0, 45.0, 0.0]]))[0]
    model_says = model.expect(samples[:, :4])
    grid_says = np.array([strength(correction, *row) for row in samples[:, :4].tolist()])
    ratio = grid_says / model_says * here
    assert np.median(np.abs(ratio / np.median(ratio) - 1.0)) < 0.03


def test_outside_its_grid_a_correction_goes_on_from_the_edge(correction: Correction) -> None:
    edge = strength(correction, 320.0, 100.0, 45.0, 0.0)
    assert strength(correction, 900.0, 100.0, 45.0, 0.0) == edge


def test_a_base_model_teaches_the_pitches_that_the_wedge_cannot() -> None:
    pitches = [sweep(pitch_deg=p).observations for p in (15.0, 30.0, 45.0, 60.0, 75.0)]
    rows = [
        (o.x_mm - 150, o.y_mm - 100, o.pitch_deg, o.yaw_deg, o.raw / 2000, np.nan)
        for seen in pitches
        for o in seen
    ]
    base = Base("pilots", "A1", np.array(rows))
    correction = solve_correction(SURFACE, base, check_sweep(sweep(), SURFACE), AT)
    flat = truth(150.0, 100.0, 20.0, 0.0) / truth(150.0, 100.0, 45.0, 0.0)
    assert strength(correction, 150.0, 100.0, 20.0, 0.0) == pytest.approx(flat, abs=0.08)
    assert correction.base == "pilots"


def test_a_base_model_of_another_sensor_that_makes_a_halo_uneven_corrects_nothing() -> None:
    seen = [replace(o, raw=2000.0 + 20.0 * (o.time_us % 5)) for o in sweep().observations]
    even = check_sweep(SweepObservations(600, 600, tuple(seen)), SURFACE)
    rng = np.random.default_rng(5)
    where = rng.uniform((-150, -100, 15, -60), (150, 100, 75, 60), (2000, 4))
    base = Base("other", "A1", np.column_stack([where, rng.uniform(0.5, 1.5, 2000), where[:, 0]]))
    fit = cross_validate(SURFACE, base, even)
    assert fit.modelled > fit.raw == fit.corrected
    assert not fit.helps
    assert np.all(solve_correction(SURFACE, base, even, AT).strength == 1.0)


@pytest.mark.parametrize(
    ("swept", "says"),
    [
        (sweep(x_to=120.0), "covered only .* missing most at the .*right"),
        (sweep(lifted=250), "off the surface in 42 %"),
        (sweep(received=200), "only 200 of 600 frames came during 'sweep'"),
        (
            SweepObservations(600, 600, sweep().observations[:200]),
            "found in only 200 of 600 frames",
        ),
    ],
    ids=["too small", "lifted", "dropped", "lost"],
)
def test_a_bad_sweep_is_refused_with_the_remedy(swept: SweepObservations, says: str) -> None:
    with pytest.raises(CalibrationError, match=says):
        check_sweep(swept, SURFACE)


def test_the_map_shows_what_is_covered() -> None:
    samples = check_sweep(sweep(), SURFACE)
    counts = covered(samples[samples[:, 0] < 150.0], SURFACE)
    assert coverage(counts) == 0.5
    assert draw_map(counts)[0] == "██████······"
