"""The numbers that a musician may change.

Rule: values only.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from halo_client.strike import LOUD_MM_S, SOFT_MM_S
from halo_midi.zone import MOST_MEMBERS


class Slide(StrEnum):
    """What moves controller 74."""

    Y = "y"
    """The place of the finger between the near and the far edge of its key."""
    HOVER = "hover"
    """Height: of the finger itself before its note, then of the lowest hovering finger."""
    OFF = "off"


@dataclass(frozen=True, slots=True)
class Settings:
    """What a musician may change."""

    members: int = MOST_MEMBERS
    """Member channels of the zone."""
    bend_semitones: int = 48
    """Pitch bend range of a member."""
    slide: Slide = Slide.Y
    hover_control: int = 1
    """Controller of the master channel that hovering moves; 0: none. 1 is the modulation wheel."""
    reach_mm: float = 50.0
    """Height up to which hovering counts."""
    soft_mm_s: float = SOFT_MM_S
    """Strike speed of the softest note."""
    loud_mm_s: float = LOUD_MM_S
    """Strike speed of velocity 127."""
    full_pressure: float = 2.0
    """Pressure of value 127; 1 is the calibrated medium press."""
