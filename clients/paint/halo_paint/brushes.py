"""The brushes and the colours: one small table, and what pressure does to each.

Rule: values and pure functions of arrays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]
Array = NDArray[np.float64]

PAPER: Colour = (250, 247, 240)
COLOURS: tuple[Colour, ...] = (
    (38, 40, 52),  # ink
    (29, 78, 137),  # ultramarine
    (0, 135, 145),  # teal
    (112, 152, 70),  # moss
    (242, 176, 53),  # saffron
    (226, 98, 58),  # vermilion
    (190, 49, 82),  # carmine
    (110, 64, 128),  # plum
)
FULL = 1.8
"""Pressure at which a brush has its full width; 1 is the calibrated medium press."""


@dataclass(frozen=True, slots=True)
class Brush:
    """Parameters of a brush."""

    name: str
    thin_mm: float
    """Width at the lightest touch."""
    thick_mm: float
    """Width at FULL pressure."""
    faint: float
    """Opacity at the lightest touch, 0 to 1."""
    dense: float
    """Opacity at FULL pressure."""
    nib_deg: float | None = None
    """Angle of a broad nib to the x axis; strokes along it are thin."""
    bristles: int = 1
    """Number of strands, each with its own ink."""


BRUSHES = (
    Brush("brush", thin_mm=1.6, thick_mm=15.0, faint=0.45, dense=0.95, bristles=14),
    Brush("pen", thin_mm=0.6, thick_mm=5.0, faint=0.8, dense=1.0),
    Brush("calligraphy", thin_mm=2.0, thick_mm=11.0, faint=0.85, dense=1.0, nib_deg=-40.0),
)
NIB = 0.18
"""Thickness of a broad nib, relative to its width."""


def share(pressure: Array) -> Array:
    """Pressure as a share of FULL, 0 to 1."""
    return np.clip(pressure / FULL, 0.0, 1.0)


def width_mm(brush: Brush, pressure: Array) -> Array:
    """Width of a stroke, mm, before its direction counts."""
    return brush.thin_mm + (brush.thick_mm - brush.thin_mm) * share(pressure)


def turned(brush: Brush, width: Array, direction: Array) -> Array:
    """Width in a direction (radians): a broad nib is thin along itself."""
    if brush.nib_deg is None:
        return width
    across = np.abs(np.sin(direction - math.radians(brush.nib_deg)))
    turned_mm: Array = width * (NIB + (1 - NIB) * across)
    return turned_mm


def ink(brush: Brush, pressure: Array, along_mm: Array, seed: int) -> Array:
    """(N, bristles) opacity of each strand along a stroke.

    Pressed hard, all strands are wet; at a light touch some run dry, and streaks appear.
    """
    opacity = brush.faint + (brush.dense - brush.faint) * share(pressure)
    if brush.bristles == 1:
        return opacity[:, None]
    rng = np.random.default_rng(seed)
    thirst = rng.permutation(np.linspace(0.0, 0.8, brush.bristles))
    waves = rng.uniform(9.0, 40.0, (2, brush.bristles))
    phases = rng.uniform(0.0, 2 * np.pi, (2, brush.bristles))
    unsteady = np.sin(2 * np.pi * along_mm[:, None, None] / waves + phases).mean(axis=1)
    wet = np.clip((share(pressure)[:, None] + 0.3 - thirst + 0.22 * unsteady) / 0.35, 0.0, 1.0)
    strands: Array = opacity[:, None] * (0.12 + 0.88 * wet)
    return strands
