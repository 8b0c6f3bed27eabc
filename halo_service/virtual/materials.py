"""The materials of tables.

`halo` scales the dent relative to plain paper. Order from the paper (4.5, 6.4): foam board gives
significantly less halo, a suede sleeve much more, water makes no difference, what only mirrors
(4.1.1: specular reflection) gives none. The numbers are chosen. Infrared reflectances are
typical diffuse values at 850 nm, chosen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Grain = Literal["plain", "wood", "weave", "specks"]


@dataclass(frozen=True, slots=True)
class Material:
    """One surface."""

    halo: float
    """Of the dent on plain paper."""
    infrared: float
    """Diffuse reflectance in the near infrared, 0 to 1."""
    colour: tuple[float, float, float]
    """Blue, green, red, 0 to 1."""
    grain: Grain = "plain"
    contrast: float = 0.0
    """How strongly the grain shows, of the colour."""
    holes: float = 0.0
    """Share of pixels without depth: what mirrors sends little light back."""
    offset_mm: float = 0.0
    """How much too far it reads."""


MATERIALS = {
    "paper": Material(1.0, 0.75, (0.86, 0.87, 0.87)),
    "wood": Material(0.95, 0.60, (0.36, 0.52, 0.68), "wood", 0.16),
    "suede": Material(1.5, 0.42, (0.30, 0.33, 0.36), "specks", 0.08),
    "plastic": Material(0.85, 0.68, (0.80, 0.80, 0.78), "plain"),
    "foam": Material(0.6, 0.80, (0.90, 0.90, 0.90), "specks", 0.03),
    "wet": Material(0.95, 0.52, (0.30, 0.45, 0.60), "wood", 0.16, holes=0.004),
    # Red brick reads 10 mm too far, black does so towards the image's edge
    # (Azure-Kinect-Sensor-SDK #1570). Reflectances and halos are chosen.
    "brick": Material(0.9, 0.40, (0.22, 0.28, 0.55), "specks", 0.10, offset_mm=10.0),
    "black": Material(0.8, 0.06, (0.05, 0.05, 0.05), "plain"),
    "mirror": Material(0.0, 0.12, (0.55, 0.55, 0.53), "plain", holes=0.35),
}
STUDIED = ("paper", "wood", "suede", "plastic", "foam")
"""The paper's five (5.2); a seed draws one of these, the others are named in a source."""
