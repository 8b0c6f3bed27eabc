"""A profile: the empty surface, where it lies, and how a finger's halo reads on it.

Rule: frozen values. `store` writes them to disk; the calibration computes them from measurements.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.matrix import Matrix3, Matrix4
from halo_service.geometry.surface import Surface
from halo_service.values import Side

PAPER_THRESHOLD_MM = 8.0
"""Excess depth from which a pixel is halo, where nothing better is known (paper 4.3.1)."""

Floats = NDArray[np.float32]
Quality = Literal["good", "fair"]
Calibrated = Literal["none", "partial", "complete"]


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """The empty surface, pixel by pixel."""

    mean_mm: NDArray[np.float32]
    """(H, W) mean depth."""
    noise_mm: NDArray[np.float32]
    """(H, W) standard deviation over the frames."""
    valid: NDArray[np.bool_]
    """(H, W) True where enough frames had a measurement."""
    infrared: NDArray[np.float32] | None = None
    """(H, W) mean infrared; None in an older profile."""
    infrared_noise: float = 0.0
    """Standard deviation of a pixel's infrared over the frames, as a share of its mean."""


@dataclass(frozen=True, slots=True)
class TouchState:
    """One of the states that the user held still."""

    signal: float
    """Median halo signal while it was held, corrected to the calibration's place, mm px."""
    height_mm: float
    """Height of the pad; 0 in contact."""
    force_g: float
    """0 in the air, -1 in contact when unknown."""
    stated: bool = False
    """Whether height and force were given (by spacers, by a kitchen scale); else assumed."""
    raw: float = 0.0
    """The signal before correction, mm px."""
    x_mm: float = 0.0
    y_mm: float = 0.0
    """Where it was held, on the surface."""
    pitch_deg: float = 45.0
    yaw_deg: float = 0.0
    """How the finger pointed."""
    readings: tuple[float, ...] = ()
    """Medians of all readings (see `sensing.readings`), corrected likewise; all 0 where one was
    hidden too often. Empty in an older profile: only the signal was calibrated."""
    raw_readings: tuple[float, ...] = ()
    """The same before correction."""
    noise: tuple[float, ...] = ()
    """Standard deviation of each from frame to frame."""
    top_mm: float | None = None
    """Height that the finger's upper side read, by its own depth, as it would be at the sweep's
    place: too low by the skin's offset, and the lower the stronger the halo. None where it was not
    measured."""
    raw_top_mm: float | None = None
    """The same where it was held; None in an older profile."""
    top_noise_mm: float = 0.0
    """Standard deviation of that from frame to frame."""
    seen_deg: float | None = None
    """Angle between the finger and the line of sight; None: by its place and how it pointed."""


@dataclass(frozen=True, slots=True)
class TouchStates:
    """The four states of the paper's first calibration task (section 4.3.5), and one more."""

    hover: TouchState
    subtle: TouchState
    touch: TouchState
    pressure: TouchState
    line_px_at_hover: float
    """Halo pixels on the finger's line in the hover state."""
    finger_thickness_mm: float
    """From the pad to the finger's upper side above it."""
    tip_radius_mm: float = 7.0
    """Half the fingertip's width (where unmeasured: half an adult's index finger, chosen)."""
    hard: TouchState | None = None
    """A press harder than the medium one, for the far end of the force's curve; None: not held."""
    nail_mm: float = 0.0
    """How far the outline reaches beyond the fingertip, along the finger: a long nail."""

    def with_each(self, changed: Callable[[TouchState], TouchState]) -> TouchStates:
        """Return the same with every held state changed, the hard press too where there is one."""
        return replace(
            self,
            hover=changed(self.hover),
            subtle=changed(self.subtle),
            touch=changed(self.touch),
            pressure=changed(self.pressure),
            hard=None if self.hard is None else changed(self.hard),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """How strong a touch's halo is over place and angle, relative to where the states were held.

    A grid of the regressor's predictions (paper 4.3.4), so that sensing interpolates in
    microseconds and needs no regressor; the samples are stored, so that it can be fitted again.
    """

    x_mm: Floats
    y_mm: Floats
    pitch_deg: Floats
    yaw_deg: Floats
    """The grid's axes, each evenly spaced and rising."""
    strength: Floats
    """(x, y, pitch, yaw) expected signal over that at the calibration's place and angle."""
    samples: Floats
    """(N, 9) what the user swept: x and y in mm, pitch and yaw in degrees, then the readings and
    the height of the finger's upper side in mm, as at 45 degrees to the line of sight; nan where
    one was hidden or, in an older profile, not stored."""
    base: str
    """Name of its base model; empty: the user's samples only."""
    readings: Floats | None = None
    """(4, x, y) each reading of a touch over that at the calibration's place; None: not known."""
    deviations: Floats | None = None
    """(4, x, y) the standard deviation of its logarithm."""
    dent_by_pitch: Floats | None = None
    """(pitch,) depth of a touch's dent over that at the calibration's pitch."""
    tops_mm: Floats | None = None
    """(2, x, y) how much higher the upper side of a touching finger reads than at the calibration's
    place, and the standard deviation of that; None: not known."""


@dataclass(frozen=True, slots=True, eq=False)
class Projector:
    """Where a projector's pixels are on the surface."""

    width_px: Annotated[int, Gt(0)]
    height_px: Annotated[int, Gt(0)]
    """Its picture."""
    projector_from_surface: Matrix3
    """(3, 3) homography, mm -> px, its last element 1; (0, 0) is the outer corner of the top left
    pixel."""


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A printed marker that others see too, such as headsets."""

    family: str
    """The family of the marker, e.g. `apriltag-36h11`."""
    marker: int
    """Its number."""
    size_mm: Annotated[float, Gt(0.0)]
    """Of its black square."""
    anchor_from_surface: Matrix4
    """(4, 4), mm: from the surface's frame to the marker's, which has its origin in its middle, x
    to its right, y to its bottom and z into it."""


CHANGING = ("background", "surface", "touch", "sweep", "projector")
"""Steps that change where and when touches are found, so that they must be verified again."""


@dataclass(frozen=True, slots=True)
class StepRecord:
    """How one step of the calibration went."""

    date: str
    """When its frames were taken, ISO 8601 in UTC."""
    quality: Quality
    figures: Mapping[str, float]
    """What was measured, its error among it; the names bear the units."""
    note: str = ""
    """What a person should know of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """One place and user."""

    name: str
    camera: Camera
    """The camera it was made with; it fits no other."""
    surface: Surface
    background: Background
    touch: TouchStates | None
    """For all fingers, unless `by_hand` has others; None before the touch step."""
    revision: int
    """Grows with every change."""
    by_hand: Mapping[Side, TouchStates] = field(default_factory=dict)
    """Hands with states of their own."""
    correction: Correction | None = None
    """None before the sweep."""
    halo_threshold_mm: float = PAPER_THRESHOLD_MM
    """Excess depth from which a pixel is halo here."""
    projector: Projector | None = None
    """None where there is none, or none was calibrated."""
    anchor: Anchor | None = None
    """Likewise."""
    steps: Mapping[str, StepRecord] = field(default_factory=dict)
    """How each step went, by its name."""

    @property
    def calibrated(self) -> Calibrated:
        """`complete` when touches can be read with it."""
        return "partial" if self.touch is None else "complete"

    @property
    def changed(self) -> str:
        """Date of the newest step that changes touches, as in its record; empty if unknown."""
        return max((each.date for name, each in self.steps.items() if name in CHANGING), default="")

    def states(self, side: Side) -> TouchStates | None:
        """Return the four states that hold for a hand."""
        return self.by_hand.get(side, self.touch)
