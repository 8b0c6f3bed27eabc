"""The values that the packages exchange.

Rule: values only. Frozen, no I/O, no clock, no method that computes more than a view of its
fields. Each field states its unit and its space.

`Frame -> hands -> tracks -> fingertip measurements -> contacts -> TouchFrame -> bytes`
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Depth = NDArray[np.uint16]
Infrared = NDArray[np.uint16]
Pixels = NDArray[np.float64]

SourceKind = Literal["camera", "recording", "virtual"]
"""Where frames come from. It is sent to clients, so that none takes a simulation for real."""


class Side(IntEnum):
    """Which hand, as the wire numbers it."""

    UNKNOWN = 0
    LEFT = 1
    RIGHT = 2


class Finger(IntEnum):
    """Which finger, as the wire numbers it."""

    THUMB = 0
    INDEX = 1
    MIDDLE = 2
    RING = 3
    LITTLE = 4


class Touch(IntEnum):
    """A pointer's state, as the wire numbers it."""

    HOVER = 0
    TOUCH = 1


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One capture of the depth camera."""

    time_us: int
    """Recording: the depth packet's timestamp. Live: Unix time of the exposure."""
    depth: Depth
    """(H, W) uint16, mm along the optical axis; 0 where the camera measured nothing."""
    ir: Infrared
    """(H, W) uint16, active brightness; 65535 where it saturates."""
    colour: NDArray[np.uint8] | bytes | None = None
    """(h, w, 3) uint8 BGR, or the JPEG as the camera sent it (decoding costs 10 ms, so only code
    that needs the image decodes it), or None."""


@dataclass(frozen=True, slots=True)
class BadFrame:
    """A capture that cannot be sensed; it is counted and reported, never silently skipped."""

    time_us: int
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Hand:
    """One hand as the hand tracker sees it."""

    side: Side
    landmarks_px: Pixels
    """(21, 2) float64, depth image pixels (integers are pixel centres), in MediaPipe's order."""
    confidence: float
    """0 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """The hands that the tracker found last; older than the present frame by its latency."""

    time_us: int
    hands: tuple[Hand, ...]


@dataclass(frozen=True, slots=True)
class Fingertip:
    """One extended fingertip, moved from the tracker's frame to the present one."""

    side: Side
    finger: Finger
    tip_px: tuple[float, float]
    """The silhouette's end in the present frame, depth pixels."""
    distal_px: tuple[float, float]
    """The joint next to the tip (distal interphalangeal), depth pixels."""
    pad_mm: tuple[float, float]
    """x, y of the pad's lowest point on the surface, surface frame."""
    camera_mm: tuple[float, float, float]
    """The pad's lowest point in the depth camera's frame, at the height by its own depth."""
    top_mm: float
    """Height of the finger's upper side above the surface by its depth; nan where unmeasured."""
    pitch_deg: float
    """0 lying flat, 90 upright."""
    yaw_deg: float
    """0 pointing to the far edge, positive clockwise as the user sees it."""
    confidence: float
    """0 to 1: the tracker's, reduced by what the present frame shows."""
    width_mm: float = math.nan
    """Of the fingertip, between its two sides; nan where they are not clear."""
    px_per_mm: float = 1.0
    """How large a millimetre is in the image, at the finger's own depth."""
    seen_deg: float = 45.0
    """Angle between the finger and the line of sight; 0: the camera looks along the finger; nan
    where the pitch was not measured."""


@dataclass(frozen=True, slots=True)
class Signal:
    """The halo around one fingertip, and the finger's own depth."""

    raw: float
    """Sum of the excess depth over the halo's pixels in the patch, mm px."""
    corrected: float
    """The same, as it would read at the place and angle of the calibration."""
    readings: tuple[float, ...] = ()
    """See `sensing.readings`, each as it would be at the place of the calibration; nan where it is
    hidden."""
    deviations: tuple[float, ...] = ()
    """The standard deviation of each by its place, as a share of it."""
    at_pitch: float = 1.0
    """What the finger's pitch leaves of a touching finger's halo: it decides touch and force, but a
    finger in the air reads otherwise."""
    top_mm: float = math.nan
    """Height of the finger's upper side by its own depth, as it would be at the place of the
    calibration and at 45 degrees to the line of sight; nan where unmeasured."""
    top_deviation_mm: float = math.inf
    """The standard deviation of that by its place."""

    @property
    def dent_mm(self) -> float:
        """How deep the surface seems dented where it is deepest; nan where it is hidden."""
        return self.readings[1] if self.readings else math.nan

    @property
    def hidden(self) -> bool:
        """Whether no surface is visible around the fingertip."""
        return not any(math.isfinite(each) for each in self.readings[1:])


@dataclass(frozen=True, slots=True)
class Contact:
    """Whether a finger touches, and since when."""

    touching: bool
    count: int
    """Touches of this pointer so far, this one included."""
    ago_us: int
    """How long before this frame the last change happened, interpolated between frames."""


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """Details of a pointer for developers; written by replay, never sent."""

    camera_mm: tuple[float, float, float]
    tip_px: tuple[float, float]
    halo: float
    halo_corrected: float
    level: float
    """0 at the calibrated subtle state, 1 at touch."""
    top_mm: float
    pitch_deg: float
    yaw_deg: float
    dent_mm: float = math.nan
    """As in `Signal`; nan where it is hidden, and for methods that read none."""
    probability: float = math.nan
    """That the finger touches, by this frame alone; nan for methods that compute none."""
    height_deviation_mm: float = math.nan
    """Standard deviation of `hover_mm`; nan in touch, where unknown and for methods without one."""
    force_deviation_g: float = math.nan
    """Standard deviation of `force_g`; nan in the air, likewise."""


@dataclass(frozen=True, slots=True)
class Pointer:
    """One fingertip, as clients receive it."""

    id: int
    """Grows, never reused in a session."""
    slot: int
    """Lowest free small number, 0 to 9."""
    side: Side
    finger: Finger
    state: Touch
    x_mm: float
    y_mm: float
    """The pad on the surface, surface frame."""
    hover_mm: float
    """Height of the pad above the surface; 0 in touch."""
    pressure: float
    """0 in hover; in touch at least 0.02, 1 at the calibrated medium press, more beyond."""
    force_g: float
    """Grams if the calibration states its forces, else -1."""
    vx_mm_s: float
    vy_mm_s: float
    confidence: float
    contacts: int
    """Touches of this pointer so far."""
    diagnostics: Diagnostics


@dataclass(frozen=True, slots=True)
class TouchEvent:
    """A finger came down on the surface, or left it."""

    kind: Literal["down", "up"]
    id: int
    slot: int
    x_mm: float
    y_mm: float
    strike_mm_s: float
    """Approach speed before contact, down only; 0 for up."""
    ago_ms: float
    """How long before the frame's time it happened."""
    contacts: int


@dataclass(frozen=True, slots=True)
class TouchFrame:
    """The state of the surface at one moment: what is published."""

    time_us: int
    surface: str
    width_mm: float
    height_mm: float
    pointers: tuple[Pointer, ...] = ()
    events: tuple[TouchEvent, ...] = ()
