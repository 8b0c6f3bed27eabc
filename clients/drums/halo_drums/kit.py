"""The kit: one table of pads, and the numbers that a drummer may change.

Rule: values only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from halo_client.strike import LOUD_MM_S, SOFT
from halo_drums import voices
from halo_drums.voices import Layers

Maker = Callable[[voices.Rng], Layers]


@dataclass(frozen=True, slots=True)
class Pad:
    """An area of the surface and its sound."""

    name: str
    area: tuple[float, float, float, float]
    """Left, far, right and near edge over the surface's width and height, 0 to 1."""
    sound: Maker
    gain: float
    bend: float
    """Semitones that a full press bends the pitch by."""
    mute: float
    """Share of its loudness that a full press removes, 0 to 1."""
    note: int
    """Note number in General MIDI's drum kit."""
    chokes: tuple[str, ...] = ()
    """Pads that it silences: the closed hi-hat silences the open one."""
    colour: tuple[int, int, int] = (255, 255, 255)


# fmt: off
KIT = (
    Pad("high tom", (0.00, 0.00, 0.25, 0.66), voices.high_tom,
        gain=0.8, bend=7.0, mute=0.2, note=50, colour=(70, 190, 190)),
    Pad("low tom", (0.25, 0.00, 0.50, 0.66), voices.low_tom,
        gain=0.9, bend=7.0, mute=0.2, note=45, colour=(60, 130, 200)),
    Pad("snare", (0.50, 0.00, 0.76, 0.66), voices.snare,
        gain=0.8, bend=3.0, mute=0.8, note=38, colour=(240, 190, 80)),
    Pad("kick", (0.76, 0.00, 1.00, 0.66), voices.kick,
        gain=1.0, bend=-5.0, mute=0.4, note=36, colour=(225, 90, 75)),
    Pad("closed hat", (0.00, 0.66, 0.50, 1.00), voices.closed_hat,
        gain=0.45, bend=0.0, mute=1.0, note=42, colour=(170, 130, 220), chokes=("open hat",)),
    Pad("open hat", (0.50, 0.66, 1.00, 1.00), voices.open_hat,
        gain=0.45, bend=0.0, mute=1.0, note=46, colour=(205, 150, 205)),
)
# fmt: on


@dataclass(frozen=True, slots=True)
class Settings:
    """What a drummer may change."""

    soft: float = SOFT
    """Loudness of the softest hit, relative to the loudest."""
    loud_mm_s: float = LOUD_MM_S
    """Strike speed of the loudest hit."""
    low_mm: float = 8.0
    """Hover height of the deepest sound."""
    high_mm: float = 60.0
    """Hover height of the sharpest sound."""
    resting: float = 0.45
    """Height, 0 low to 1 high, while no second hand hovers."""
    hold_s: float = 0.2
    """A longer touch is a press; a shorter one is a tap."""
    rest_s: float = 1.0
    """A hand shapes the sound only if its last hit is older than this."""


def pad_at(kit: tuple[Pad, ...], u: float, v: float) -> Pad:
    """Return the pad at (u, v); outside the surface, the nearest edge pad."""
    u, v = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
    for pad in kit:
        left, far, right, near = pad.area
        if left <= u <= right and far <= v <= near:
            return pad
    raise ValueError(f"the kit has a hole at u {u:.2f}, v {v:.2f}")


def mirrored(kit: tuple[Pad, ...]) -> tuple[Pad, ...]:
    """The kit for a left-handed drummer."""
    return tuple(
        replace(pad, area=(1 - pad.area[2], pad.area[1], 1 - pad.area[0], pad.area[3]))
        for pad in kit
    )
