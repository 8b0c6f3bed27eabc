"""Pilots: base models from a few people's sweeps at five wedge angles (4.3.4)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from halo_calibration.errors import CalibrationError
from halo_calibration.guided.guide import GuidedCalibration, Prompt
from halo_calibration.observe import Observer
from halo_calibration.solvers.correction import Base, relative
from halo_calibration.solvers.sweep import Samples, rests, samples_of
from halo_calibration.solvers.touch import require_frames
from halo_service.geometry.surface import Surface
from halo_service.profile import Profile

ANGLES_DEG = (15.0, 30.0, 45.0, 60.0, 75.0)
ROUNDS, ROUND_S = 3, 60.0
"""Three rounds of a minute at each angle (4.3.4)."""
WEDGE_DEG = 45.0
"""A pilot's level is the median at this angle: users sweep at it."""
NEAR_DEG = 20.0
"""A pitch read farther from the wedge's was read off something else."""
LEAST_SAMPLES = 40
"""Of one angle; steep fingers are lost often, and fewer are not used."""


def pilot_rounds(
    guided: GuidedCalibration,
    observer: Observer,
    profile: Profile,
    *,
    rounds: int = ROUNDS,
    round_s: float = ROUND_S,
) -> Iterator[tuple[float, Samples]]:
    """Let one pilot sweep at all angles; yields (angle, (N, 9) samples) a round."""
    for number in range(rounds):
        for angle in ANGLES_DEG:
            words = (
                f"ROUND {number + 1} of {rounds}, WEDGE {angle:.0f} DEGREES: rest the finger on "
                f"it and draw it over the whole surface for {round_s:.0f} s, turning it a little."
            )
            swept = guided.swept(Prompt("pilot", words, angle), round_s, observer, profile)
            require_frames(f"wedge {angle:.0f}", swept.expected, swept.received)
            yield angle, usable(samples_of(swept.observations), angle)


def usable(samples: Samples, angle_deg: float) -> Samples:
    """Leave out lifted fingers, and angles that were read off something else."""
    if len(samples) == 0:
        return samples
    near = np.abs(samples[:, 2] - angle_deg) < NEAR_DEG
    return np.asarray(samples[rests(samples) & near], dtype=np.float64)


def pilot_samples(surface: Surface, rounds: Sequence[tuple[float, Samples]]) -> Samples:
    """Make one pilot's rounds comparable to another's: (N, 6), relative to the level at 45.

    Raises `CalibrationError` where the wedge's own angle has too few samples.
    """
    wedge = [samples for angle, samples in rounds if angle == WEDGE_DEG]
    level = np.concatenate(wedge)[:, 4:6] if wedge else np.empty((0, 2))
    if len(level) < LEAST_SAMPLES:
        raise CalibrationError(
            f"only {len(level)} usable frames came at {WEDGE_DEG:.0f} degrees: keep the finger "
            f"on the wedge and its tip on the surface, and run the pilot again"
        )
    usable_rounds = [samples for _, samples in rounds if len(samples) >= LEAST_SAMPLES]
    return relative(np.concatenate(usable_rounds), surface, _medians(level))


def merged(name: str, camera_serial: str, pilots: Sequence[Samples]) -> Base:
    """Return a base model of several pilots."""
    return Base(name, camera_serial, np.concatenate(pilots))


def _medians(level: Samples) -> tuple[float, float]:
    """Return the medians of (N, 2) signals and dents; hidden dents are left out."""
    signal, dent = np.nanmedian(level, axis=0).tolist()
    return signal, dent
