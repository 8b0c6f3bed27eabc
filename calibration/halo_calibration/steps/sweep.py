"""The step of the sweep: how a touch's halo changes over place and angle."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from halo_calibration.errors import CalibrationError
from halo_calibration.observe import Observer
from halo_calibration.solvers.correction import (
    Base,
    Reference,
    cross_validate,
    solve_correction,
)
from halo_calibration.solvers.dents import least_variation
from halo_calibration.solvers.sweep import (
    GOOD_COVERED,
    Samples,
    SweepObservations,
    check_sweep,
    coverage,
    covered,
)
from halo_calibration.solvers.touch import corrected
from halo_calibration.steps.change import Change, Setup, Watch, require, rounded, watched
from halo_service.profile import Profile, StepRecord
from halo_service.values import Frame

FAIR_CORRECTED = 0.15
"""A corrected touch that varies more over the sweep is rated fair."""


def watch_sweep(
    frames: Iterable[Frame], expected: int, observer: Observer, watch: Watch
) -> SweepObservations:
    """Watch a finger that is drawn over the surface."""
    received, observations = watched(frames, observer, watch)
    return SweepObservations(expected, received, observations)


def sweep_change(setup: Setup, swept: SweepObservations, profile: Profile) -> Change:
    """Calibrate the correction from a sweep. Raises `CalibrationError` if the sweep is poor."""
    surface = profile.surface
    samples = check_sweep(swept, surface)
    fit = cross_validate(surface, setup.base, samples)
    left = min(fit.modelled, least_variation(samples))
    if left > fit.raw and left > FAIR_CORRECTED:
        raise CalibrationError(
            f"the halo of the sweep cannot be predicted ({100 * left:.0f} % is left of "
            f"{100 * fit.raw:.0f} %): rest the finger on the wedge all the time, draw it slowly "
            f"and evenly, and sweep again"
        )
    share = coverage(covered(samples, surface))
    good = share >= GOOD_COVERED and left < FAIR_CORRECTED
    record = StepRecord(
        setup.date,
        "good" if good else "fair",
        rounded(
            samples=len(samples),
            covered_share=share,
            variation_raw=fit.raw,
            variation_corrected=fit.corrected,
        ),
        "" if setup.base else "no base model: pitches other than the wedge's are not corrected",
    )

    def change(before: Profile | None) -> Profile:
        known = require(before, "sweep")
        return _with_correction(known, setup.base, samples, record)

    return change


def _with_correction(
    known: Profile, base: Base | None, samples: Samples | None, record: StepRecord
) -> Profile:
    assert known.touch is not None  # `require` saw to it
    held = known.touch.touch
    at = Reference(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
    correction = solve_correction(known.surface, base, samples, at)
    return replace(
        known,
        correction=correction,
        touch=corrected(known.touch, correction),
        by_hand={side: corrected(each, correction) for side, each in known.by_hand.items()},
        steps={**known.steps, "sweep": record},
    )
