"""What a step of the calibration is given, and what it makes: a change of the profile."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from halo_calibration.errors import CalibrationError
from halo_calibration.observe import Observation, Observer
from halo_calibration.solvers.correction import Base
from halo_calibration.solvers.touch import StateValues
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Frame, Side

Change = Callable[[Profile | None], Profile]
"""What a step makes of the profile as it is now; None: there is none yet."""
Watch = Callable[[Observation | None], None]
"""Is shown each frame's finger, for the live signal."""

STEPS = ("background", "surface", "touch", "sweep")
"""In the order in which they build on each other."""


@dataclass(frozen=True, slots=True)
class Setup:
    """What stays the same over all steps of one calibration."""

    name: str
    """Of the profile."""
    camera: Camera
    date: str
    """When the frames were taken, ISO 8601 in UTC."""
    settings: SensingSettings = field(default_factory=SensingSettings)
    state_values: StateValues = field(default_factory=StateValues)
    base: Base | None = None
    side: Side = Side.UNKNOWN
    """Unknown: one set of touch parameters for all fingers; else for that hand alone."""


def require(profile: Profile | None, step: str) -> Profile:
    """Return the profile of the steps before. Raises `CalibrationError` if a step is missing."""
    if profile is None:
        raise CalibrationError(
            f"'{step}' needs the background first: run 'halo calibrate background'"
        )
    if step == "sweep" and profile.touch is None:
        raise CalibrationError("'sweep' needs the four states first: run 'halo calibrate touch'")
    return profile


def watched(
    frames: Iterable[Frame], observer: Observer, watch: Watch
) -> tuple[int, tuple[Observation, ...]]:
    received, observations = 0, []
    for frame in frames:
        received += 1
        observation = observer.see(frame)
        watch(observation)
        if observation is not None:
            observations.append(observation)
    return received, tuple(observations)


def rounded(**figures: float) -> dict[str, float]:
    """Return a step's figures as they are stored."""
    return {name: round(float(value), 4) for name, value in figures.items()}
