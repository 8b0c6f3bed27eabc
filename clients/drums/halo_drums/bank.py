"""The sounds of a kit, made once when the program starts.

Rule: pure, and the same at every start. A pad has several takes, so that two hits never sound
the same; the room around the drums is in the takes already and costs nothing while playing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halo_drums.kit import Pad
from halo_drums.voices import RATE, Layers, Rng, Wave, decay, time

TAKES = 4
ROOM_S = 0.35
ROOM_DECAY_S = 0.07
ROOM_LEVEL = 0.16
PAN = 0.35
"""How far the outermost pad is from the middle; 1 would be in one ear only."""

Take = NDArray[np.float32]
"""(N, 4): deep left, deep right, sharp left, sharp right. Begins and ends at 0."""
Bank = dict[str, list[Take]]


def make_bank(kit: tuple[Pad, ...], seed: int = 1) -> Bank:
    """Pad name -> its takes. Some tenths of a second of work."""
    room = _room(np.random.default_rng(seed))
    bank: Bank = {}
    for number, pad in enumerate(kit):
        rngs = [np.random.default_rng([seed, number, take]) for take in range(TAKES)]
        bank[pad.name] = [_take(pad, pad.sound(rng), room) for rng in rngs]
    return bank


def _take(pad: Pad, layers: Layers, room: tuple[Wave, Wave]) -> Take:
    aside = PAN * (pad.area[0] + pad.area[2] - 1.0)
    sides = (np.sqrt((1 - aside) / 2), np.sqrt((1 + aside) / 2))
    columns = [
        pad.gain * side * _within(wave, echo)
        for wave in (layers.deep, layers.sharp)
        for side, echo in zip(sides, room, strict=True)
    ]
    take: Take = np.stack(columns, axis=1).astype(np.float32)
    return take


def _room(rng: Rng) -> tuple[Wave, Wave]:
    """A small room's echoes for either ear: noise that fades."""
    t = time(ROOM_S)
    fading = decay(t, ROOM_DECAY_S) * np.minimum(1.0, t / 0.012) * (1 - t / ROOM_S)
    ears = [rng.standard_normal(len(t)) * fading for _ in range(2)]
    left, right = (ROOM_LEVEL * ear / np.sqrt((ear**2).sum()) for ear in ears)
    return left, right


def _within(wave: Wave, echo: Wave) -> Wave:
    """The sound and its echoes, by convolution."""
    length = len(wave) + len(echo)
    spectrum = np.fft.rfft(wave, length) * np.fft.rfft(echo, length)
    sounded: Wave = np.fft.irfft(spectrum, length)
    sounded[: len(wave)] += wave
    fall = round(0.005 * RATE)
    sounded[-fall:] *= np.linspace(1.0, 0.0, fall)
    sounded[0] = 0.0
    return sounded
