"""The sounds of keys, on the drums' mixer: one for letters, others for delete and done.

Rule: pure. Each sound is a pad without a place, computed as in `halo_drums.voices`.
"""

from __future__ import annotations

from halo_client import TouchKey
from halo_drums.bank import Bank, make_bank
from halo_drums.kit import Pad
from halo_drums.player import Hit
from halo_drums.voices import Layers, Rng, band, decay, layers, sine, time
from halo_type.layout import DELETE, DONE
from halo_type.typist import Struck

EVERYWHERE = (0.0, 0.0, 1.0, 1.0)
LEVEL = 0.6


def _click(rng: Rng, pitch_hz: float, length_s: float) -> Layers:
    """A short knock, as of a finger on wood."""
    t = time(0.12)
    knock = sine(t, pitch_hz) * decay(t, length_s) + 0.6 * band(rng, t, 1500.0, 6000.0) * decay(
        t, 0.004
    )
    return layers(knock, knock)


def _pad(name: str, pitch_hz: float, length_s: float) -> Pad:
    return Pad(
        name,
        EVERYWHERE,
        lambda rng: _click(rng, pitch_hz, length_s),
        gain=0.5,
        bend=0.0,
        mute=0.0,
        note=0,
    )


LETTER = _pad("letter", 820.0, 0.012)
SOUNDS = {DELETE: _pad(DELETE, 420.0, 0.02), DONE: _pad(DONE, 1240.0, 0.06)}


def key_sounds() -> Bank:
    """Return the samples of all sounds."""
    return make_bank((LETTER, *SOUNDS.values()))


def sound_of(struck: Struck) -> Hit | None:
    """Return the gesture for the mixer; None for a touch next to the keys."""
    if struck.character is None:
        return None
    pad = SOUNDS.get(struck.character, LETTER)
    key = TouchKey("type", "type", "type", struck.time_us, 0)
    return Hit(struck.time_us, key, pad, LEVEL, 0.5, 0.5)
