"""The kit: one table of pads, and the few numbers that a drummer may want to turn.

Rule: values only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from halo_drums import voices
from halo_drums.voices import Layers

Maker = Callable[[voices.Rng], Layers]


@dataclass(frozen=True, slots=True)
class Pad:
    """A place on the surface and what sounds there."""

    name: str
    area: tuple[float, float, float, float]
    """Left, far, right and near edge over the surface's width and height, 0 to 1."""
    sound: Maker
    gain: float
    bend: float
    """Semitones that a full press after the strike bends it by; 0 for pads that do not bend."""
    mute: float
    """How much of it a full press takes away, 0 to 1."""
    note: int
    """Its number in General MIDI's drum kit."""
    chokes: tuple[str, ...] = ()
    """Pads that it silences, as a closing hi-hat silences the open one."""
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
    """What a drummer may turn."""

    soft: float = 0.25
    """Loudness of the softest hit, over the loudest's."""
    loud_mm_s: float = 400.0
    """A strike as fast as this is as loud as it gets."""
    low_mm: float = 8.0
    """Hovering so low is all deep."""
    high_mm: float = 60.0
    """Hovering so high is all sharp."""
    resting: float = 0.45
    """The height, 0 low to 1 high, as long as no second hand hovers."""
    hold_s: float = 0.2
    """A touch that lasts longer presses; a shorter one was a tap and rings freely."""
    rest_s: float = 1.0
    """A hand shapes the sound when it has not struck for so long."""


def pad_at(kit: tuple[Pad, ...], u: float, v: float) -> Pad:
    """The pad under a place; one beyond the surface's edge belongs to the pad at the edge."""
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
