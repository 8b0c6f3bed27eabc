"""What is publicly known of the real sensor, one named parameter a fact.

Rule: numbers and their sources; how each is drawn stands where it is drawn. `TRUE` has
them all. `KIND` is a sensor with white noise and little else, for unit tests of what comes after.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SensorModel:
    """The errors of one device. Lengths in px are pixels of the narrow unbinned mode."""

    skin_times: float = 1.0
    """Share of the user's `skin_offset_mm` that is drawn."""


TRUE = SensorModel()
KIND = SensorModel(skin_times=0.22)
"""Skin reads 2 mm too far for a middling user."""
SENSORS = {"true": TRUE, "kind": KIND}
