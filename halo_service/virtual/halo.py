"""The halo: how deep the surface seems dented around a finger.

This is phenomenological. The physics of a few diffuse bounces gives dents of 1 to 2 mm; the
paper shows 8 mm and more, the rest is the sensor's own processing, which is not public.
So nothing here is derived: curves of the right shape are scaled to what the paper reports.
A figure measured on these curves is a claim about the pipeline that reads them, not about the
world. Constants say where they come from: a section of the paper, or "chosen".

The model in short. Every low point of a hand (fingertips, undersides of bones, palm) casts a dent
on the surface around it: `depth` by its height and force, spread as in `dent_field`. Dents of one
hand and its neighbours melt together. The real footprint of a fingertip is not published: a curve
is either a `bell` under the fingertip or `odd` (moved, drawn out, lopsided, with a glow). The
surface is dented, not the hand (`sensor` mixes what lies along the outline of a low finger, as a
real one averages).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.virtual.boxes import Box
from halo_service.virtual.mesh import Floats

APPROACH_MM, CONTACT_MM, PRESS_MM = 22.0, 5.0, 9.0
"""Depth that approach, contact and a firm press add on paper at 0.5 m. Chosen so that outside
the finger about 8 mm are seen at 10 mm of height, where the halo just becomes visible (4.3.5) at
the paper's threshold of 8 (4.3.1), and the four states are in order."""
CONTACT_ONSET_MM = 2.0
"""Where contact begins to be felt by the light; subtle (1 mm) lies between. Chosen."""
FIRM_G = 385.0
"""The strongest press of the paper's study (5.2)."""
RADIUS_MM = 11.0
"""Of the footprint at 0.5 m. The paper's patch of 30x20 pixels (about as many mm) holds a whole
halo (4.3.3)."""
REFERENCE_MM = 500.0
"""The paper's working distance (5.1)."""
SIDE_WEIGHT = 0.6
"""What an underside that is no fingertip dents, of what a fingertip at its height does. Chosen."""
CORNERS = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
"""Directions from the surface's middle, right and near."""
HALF_MM = 150.0, 100.0
"""Half the paper's interaction area (6.4)."""
GLOW_REACH = 2.0
"""A glow ends at this many times its reach."""
GLOW_FLESH_MM = 15.0
"""A glow is whole within this distance of a knuckle or fingertip: about the flesh around it."""
GLOW_STEP = 4
MELT = 3.0
"""Order of the norm that joins dents: below the sum, above the deepest. Chosen."""


def _straight(height: Floats, onset: float) -> Floats:
    return (1.0 - height / onset) ** 0.9


def _exponential(height: Floats, onset: float) -> Floats:
    length = 1.5 * onset
    end = np.exp(-onset / length)
    return np.asarray((np.exp(-height / length) - end) / (1.0 - end))


def _sigmoid(height: Floats, onset: float) -> Floats:
    def raw(h: Floats | float) -> Floats:
        return np.asarray(1.0 / (1.0 + np.exp((np.asarray(h) - 0.5 * onset) / (0.16 * onset))))

    return (raw(height) - raw(onset)) / (raw(0.0) - raw(onset))


def _saturating(force: float, soft: float) -> float:
    return 1.0 - float(np.exp(-force / soft))


def _logarithmic(force: float, soft: float) -> float:
    return float(np.log1p(8.0 * force / soft))


def _power(force: float, soft: float) -> float:
    return float((force / soft) ** 0.85)


@dataclass(frozen=True, slots=True)
class Family:
    """How a halo grows."""

    approach: Callable[[Floats, float], Floats]
    """Height, onset -> 0 at the onset, 1 at contact."""
    press: Callable[[float, float], float]
    """Force, how soft -> grows from 0; scaled so that a firm press gives 1."""


FAMILIES = {
    "straight": Family(_straight, _saturating),
    "exponential": Family(_exponential, _power),
    "sigmoid": Family(_sigmoid, _logarithmic),
}
"""The paper gives the ends (onset at about 20 mm, growth with deformation, 4.1.3) and says that
every dependence is non-linear; the shapes in between are chosen, several, so that nothing is
tuned to one."""


@dataclass(frozen=True, slots=True)
class HaloCurve:
    """How one user's finger on one table grows its halo."""

    family: str = "straight"
    onset_mm: float = 20.0
    """Height where the halo begins (4.1.3: about 2 cm)."""
    gain: float = 1.0
    """Of the chosen depths; users differ."""
    press_g: float = 220.0
    """How soft the finger is, as the family's press has it; chosen."""
    across_deg: float = 0.0
    """Direction over the table in which the halo varies by place; chosen per seed."""
    press_power: float = 0.0
    """The press grows as this power of the force; 0: as the family's press."""
    press_saturates: bool = False
    """Whether a press with a power levels off, softly, around `press_g`."""
    corner_fall: float = 0.0
    """Share of the strength that is lost at one corner of the surface."""
    corner: int = 0
    """Which corner: 0 far left, 1 far right, 2 near right, 3 near left."""
    wider_high: float = 0.0
    """How much wider the footprint is at the onset than at contact, share of the radius."""
    wider_pressed: float = 0.0
    """How much wider the footprint is under a firm press, share of the radius."""
    shift_mm: float = 0.0
    """How far the footprint lies from the pad towards the palm."""
    stretch: float = 1.0
    """Length of the footprint along the finger over its width."""
    lopsided: float = 0.0
    """Gain of the right side and loss of the left one, seen along the finger; share."""
    glow_mm: float = 0.0
    """Depth of the shallow glow around a hand that lies low."""
    glow_reach_mm: float = 35.0
    """Distance at which 1/e of the glow is left."""

    @property
    def shape(self) -> str:
        """`bell` or `odd`."""
        bell = (self.shift_mm, self.stretch, self.lopsided, self.glow_mm) == (0.0, 1.0, 0.0, 0.0)
        return "bell" if bell else "odd"

    def press(self, force_g: float) -> float:
        """What a force adds, as a share of what a firm press adds."""
        if self.press_power == 0.0:
            family = FAMILIES[self.family]
            return family.press(force_g, self.press_g) / family.press(FIRM_G, self.press_g)
        return self._power(force_g) / self._power(FIRM_G)

    def _power(self, force_g: float) -> float:
        # Rounding can leave a force a little below 0, and a power of that is no number.
        grown = (max(force_g, 0.0) / self.press_g) ** self.press_power
        return 1.0 - float(np.exp(-grown)) if self.press_saturates else float(grown)


def depth(
    curve: HaloCurve,
    height_mm: float,
    force_g: float = 0.0,
    fade: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> float:
    """Depth under a fingertip on paper, mm; `fade` scales approach, contact and press apart."""
    family = FAMILIES[curve.family]
    height = float(np.clip(height_mm, 0.0, curve.onset_mm))
    approach = float(family.approach(np.array(height), curve.onset_mm))
    contact = max(0.0, 1.0 - height / CONTACT_ONSET_MM) ** 2
    parts = APPROACH_MM * approach, CONTACT_MM * contact, PRESS_MM * curve.press(force_g)
    return curve.gain * sum(f * p for f, p in zip(fade, parts, strict=True))


# How approach, contact and press fade with the camera's place. The paper gives what is left of
# the *signal* of each sensing region (6.4): approach below 50 % at 80 cm, 25 degrees of yaw, 15
# of pitch; contact above 75 % up to 100 cm, 50, 45; press above 75 % up to 70 cm, 35, 45, and
# amplified from -35 to 0 of pitch. The signal counts only what is deeper than a threshold and not
# hidden behind the hand, so the dent itself has to change less, and here and there the other way:
# these factors were chosen so that the signal measured on the frames does what the paper says.
_FADE_DISTANCE = (
    (300.0, 500.0, 600.0, 700.0, 800.0, 1000.0, 1200.0, 1500.0),
    (
        (1.40, 1.0, 0.86, 0.76, 0.64, 0.53, 0.50, 0.40),
        (1.20, 1.0, 0.78, 0.80, 0.95, 1.00, 0.75, 0.50),
        (1.30, 1.0, 0.92, 0.84, 0.70, 0.56, 0.35, 0.20),
    ),
)
_FADE_YAW = (
    (0.0, 10.0, 25.0, 35.0, 50.0, 60.0),
    (
        (1.0, 0.94, 0.54, 0.48, 0.39, 0.36),
        (1.0, 0.88, 1.10, 0.90, 0.86, 0.48),
        (1.0, 0.98, 0.80, 1.05, 0.90, 0.68),
    ),
)
_FADE_PITCH = (
    (-60.0, -45.0, -35.0, -15.0, 0.0, 15.0, 30.0, 45.0, 60.0),
    (
        (0.38, 0.42, 0.46, 0.63, 1.0, 0.79, 0.59, 0.43, 0.30),
        (0.44, 0.60, 0.58, 0.60, 1.0, 1.12, 1.60, 1.30, 0.80),
        (0.85, 1.03, 1.20, 1.28, 1.0, 0.95, 1.60, 2.20, 1.20),
    ),
)


def fading(distance_mm: float, yaw_deg: float, pitch_deg: float) -> tuple[float, float, float]:
    """What camera distance and tilt leave of approach, contact and press."""
    parts = []
    for part in range(3):
        by_distance = np.interp(distance_mm, _FADE_DISTANCE[0], _FADE_DISTANCE[1][part])
        by_yaw = np.interp(abs(yaw_deg), _FADE_YAW[0], _FADE_YAW[1][part])
        by_pitch = np.interp(pitch_deg, _FADE_PITCH[0], _FADE_PITCH[1][part])
        parts.append(float(by_distance * by_yaw * by_pitch))
    return parts[0], parts[1], parts[2]


_POSTURE = (0.0, 15.0, 30.0, 45.0, 60.0, 90.0), (0.3, 0.8, 0.95, 1.0, 0.97, 0.9)


def posture(pitch_deg: float) -> float:
    """What the finger's pitch leaves: weak below 15 degrees (4.3.4), else nearly flat (chosen)."""
    return float(np.interp(pitch_deg, *_POSTURE))


def by_place(curve: HaloCurve, x_mm: float, y_mm: float) -> float:
    """Strength at a place, mm from the surface's middle; 1 without any change.

    The halo is not the same everywhere (4.1.3): a slope of +-8 % over 15 cm, and a loss of
    `corner_fall` at one corner that is 0 at the opposite one. Both chosen.
    """
    across = np.radians(curve.across_deg)
    slope = 0.08 * np.tanh((x_mm * np.cos(across) + y_mm * np.sin(across)) / 150.0)
    right, near = CORNERS[curve.corner]
    towards = (right * x_mm / HALF_MM[0] + near * y_mm / HALF_MM[1]) / 2.0
    return float((1.0 + slope) * (1.0 - curve.corner_fall * np.clip((1.0 + towards) / 2.0, 0, 1)))


def radius_mm(
    distance_mm: float, curve: HaloCurve | None = None, height_mm: float = 0.0, force_g: float = 0.0
) -> float:
    """Radius of the footprint: between constant in mm (the light's share) and constant in pixels
    (the sensor's), wider as the curve says. Chosen."""
    radius = RADIUS_MM * float(np.sqrt(distance_mm / REFERENCE_MM))
    if curve is None:
        return radius
    high = curve.wider_high * min(1.0, height_mm / curve.onset_mm)
    return radius * (1.0 + high + curve.wider_pressed * min(1.0, force_g / FIRM_G))


@dataclass(frozen=True, slots=True)
class Dent:
    """What one low point of a hand does to the surface."""

    x_mm: float
    y_mm: float
    """Middle of the footprint, on the surface."""
    depth_mm: float
    radius_mm: float
    """Across the finger."""
    along: tuple[float, float] = (0.0, -1.0)
    """Unit vector on the surface, where the finger points."""
    stretch: float = 1.0
    lopsided: float = 0.0

    def shares(self, x_mm: NDArray[np.float32], y_mm: NDArray[np.float32]) -> NDArray[np.float32]:
        """Depth at places, mm, to the power of MELT."""
        dx, dy = x_mm - np.float32(self.x_mm), y_mm - np.float32(self.y_mm)
        deep = np.float32(self.depth_mm**MELT)
        if self.stretch == 1.0 and self.lopsided == 0.0:
            squared = np.asarray(dx * dx + dy * dy, np.float32) / np.float32(self.radius_mm**2)
            return deep * _bell(squared)
        along_x, along_y = np.float32(self.along[0]), np.float32(self.along[1])
        ahead = (dx * along_x + dy * along_y) / np.float32(self.radius_mm * self.stretch)
        right = (dy * along_x - dx * along_y) / np.float32(self.radius_mm)
        tilt = 1.0 + np.float32(self.lopsided) * right / np.sqrt(1.0 + right * right)
        return np.asarray(deep * tilt**MELT * _bell(np.asarray(ahead**2 + right**2)), np.float32)


def _bell(squared: NDArray[np.float32]) -> NDArray[np.float32]:
    """The footprint to the power of MELT, from squared distances in radii."""
    return np.asarray(np.exp(np.float32(-MELT) * squared * np.sqrt(squared)), dtype=np.float32)


@dataclass(frozen=True, slots=True)
class Glow:
    """What one point of a low hand adds to the surface, far and shallow."""

    x_mm: float
    y_mm: float
    depth_mm: float
    reach_mm: float


def glow_field(
    glows: list[Glow], x_mm: NDArray[np.float32], y_mm: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Depth of the deepest glow at places on the surface, mm; x and y (H, W).

    Computed on a grid that is GLOW_STEP times coarser: a glow changes over centimetres.
    """
    rows, columns = x_mm.shape
    size = max(1, columns // GLOW_STEP), max(1, rows // GLOW_STEP)
    x, y = (cv2.resize(grid, size, interpolation=cv2.INTER_AREA) for grid in (x_mm, y_mm))
    deepest: NDArray[np.float32] = np.zeros(x.shape, np.float32)
    end = np.float32(np.exp(-(GLOW_REACH**2)))  # so that the glow ends at the edge of its box
    for glow in glows:
        dx, dy = x - np.float32(glow.x_mm), y - np.float32(glow.y_mm)
        away = np.maximum(np.sqrt(dx * dx + dy * dy) - np.float32(GLOW_FLESH_MM), 0.0)
        share = np.exp(-((away / np.float32(glow.reach_mm)) ** 2)) - end
        deepest = np.maximum(deepest, np.float32(glow.depth_mm) * share)
    return np.asarray(cv2.resize(deepest, (columns, rows), interpolation=cv2.INTER_LINEAR))


def dent_field(
    dents: list[Dent],
    x_mm: NDArray[np.float32],
    y_mm: NDArray[np.float32],
    boxes: Sequence[Box] | None = None,
) -> NDArray[np.float32]:
    """Depth of all dents melted together at places on the surface, mm; any shape of x and y.

    The footprint exp(-(r / radius)^3) is flat under the finger and has a soft shoulder: at the
    finger's edge (7 mm of 11) three quarters are left, at the patch's end (15) a twelfth. Chosen.
    `boxes`: the part of x and y that each dent reaches; None: all.
    """
    total = np.zeros(x_mm.shape, np.float32)
    for number, dent in enumerate(dents):
        box = boxes[number] if boxes else ...
        total[box] += dent.shares(x_mm[box], y_mm[box])
    return np.asarray(np.cbrt(total) if MELT == 3.0 else total ** (1.0 / MELT), dtype=np.float32)
