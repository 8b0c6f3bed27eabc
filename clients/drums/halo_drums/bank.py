"""The sounds of a kit, computed once when the program starts.

Rule: pure, and the same at every start. A pad has several samples, so that two hits never sound
the same. The room echo is part of the samples and costs nothing while playing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halo_drums.kit import Pad
from halo_drums.voices import RATE, Layers, Rng, Wave, decay, time

SAMPLES = 4
ROOM_S = 0.35
ROOM_DECAY_S = 0.07
ROOM_LEVEL = 0.16
PAN = 0.35
"""Stereo position of the outermost pad; 1 is one ear only."""

Sample = NDArray[np.float32]
"""(N, 4) float32: deep left, deep right, sharp left, sharp right. Starts and ends at 0."""
Bank = dict[str, list[Sample]]


def make_bank(kit: tuple[Pad, ...], seed: int = 1) -> Bank:
    """Return pad name -> its samples; takes some tenths of a second."""
    room = _room(np.random.default_rng(seed))
    bank: Bank = {}
    for number, pad in enumerate(kit):
        rngs = [np.random.default_rng([seed, number, n]) for n in range(SAMPLES)]
        bank[pad.name] = [_sample(pad, pad.sound(rng), room) for rng in rngs]
    return bank


def _sample(pad: Pad, layers: Layers, room: tuple[Wave, Wave]) -> Sample:
    pan = PAN * (pad.area[0] + pad.area[2] - 1.0)
    sides = (np.sqrt((1 - pan) / 2), np.sqrt((1 + pan) / 2))
    columns = [
        pad.gain * side * _with_echo(wave, echo)
        for wave in (layers.deep, layers.sharp)
        for side, echo in zip(sides, room, strict=True)
    ]
    sample: Sample = np.stack(columns, axis=1).astype(np.float32)
    return sample


def _room(rng: Rng) -> tuple[Wave, Wave]:
    """Impulse response of a small room, left and right: noise that decays."""
    t = time(ROOM_S)
    fading = decay(t, ROOM_DECAY_S) * np.minimum(1.0, t / 0.012) * (1 - t / ROOM_S)
    ears = [rng.standard_normal(len(t)) * fading for _ in range(2)]
    left, right = (ROOM_LEVEL * ear / np.sqrt((ear**2).sum()) for ear in ears)
    return left, right


def _with_echo(wave: Wave, echo: Wave) -> Wave:
    """Return the sound plus its echo, by convolution."""
    length = len(wave) + len(echo)
    spectrum = np.fft.rfft(wave, length) * np.fft.rfft(echo, length)
    echoed: Wave = np.fft.irfft(spectrum, length)
    echoed[: len(wave)] += wave
    fall = round(0.005 * RATE)
    echoed[-fall:] *= np.linspace(1.0, 0.0, fall)
    echoed[0] = 0.0
    return echoed
