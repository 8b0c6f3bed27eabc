"""The sounds of the drums, each a small function.

Rule: pure NumPy, and no clock: the same generator of noise gives the same samples. Each drum has
two layers, one deep and one sharp; the mixer fades between them while they sound, so that the
hovering hand needs no filter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RATE = 48_000
"""Samples a second."""
ATTACK_S = 0.0004
"""Rise time of a sound: too short to hear as a fade, long enough not to click."""
RELEASE_S = 0.01

Wave = NDArray[np.float64]
"""(N,) samples."""
Rng = np.random.Generator


@dataclass(frozen=True, slots=True)
class Layers:
    """One hit of a drum. Both layers have the same length and a peak of 1."""

    deep: Wave
    sharp: Wave


def kick(rng: Rng) -> Layers:
    """A falling sine; sharp, it falls from higher and the beater clicks."""
    t = time(0.8)
    deep = sweep(t, 46.0, 130.0, 0.03) * decay(t, 0.24)
    beater = band(rng, t, 2000.0, 9000.0) * decay(t, 0.012)
    snap = sweep(t, 66.0, 420.0, 0.02) * decay(t, 0.11)
    return layers(driven(1.8 * deep), driven(1.5 * snap) + 0.9 * beater)


def snare(rng: Rng) -> Layers:
    """Two modes of the skin and the wires below; sharp, the wires and the stick."""
    t = time(0.5)
    skin = sweep(t, 178.0, 60.0, 0.02) * decay(t, 0.11) + 0.5 * sine(t, 331.0) * decay(t, 0.06)
    rattle = band(rng, t, 500.0, 3200.0) * decay(t, 0.13)
    wires = band(rng, t, 2600.0, 12_000.0) * (0.7 * decay(t, 0.1) + 0.5 * decay(t, 0.02))
    stick = band(rng, t, 1500.0, 6000.0) * decay(t, 0.004)
    return layers(skin + 0.35 * rattle, 0.35 * skin * decay(t, 0.06) + wires + stick)


def high_tom(rng: Rng) -> Layers:
    """The small tom."""
    return _tom(rng, 165.0, 0.75)


def low_tom(rng: Rng) -> Layers:
    """The floor tom."""
    return _tom(rng, 98.0, 1.0)


def closed_hat(rng: Rng) -> Layers:
    """Two cymbals held together."""
    return _hat(rng, 0.3, 0.045)


def open_hat(rng: Rng) -> Layers:
    """Two cymbals that sizzle."""
    return _hat(rng, 1.2, 0.3)


def _tom(rng: Rng, pitch_hz: float, length: float) -> Layers:
    """A membrane: its pitch sinks as the skin relaxes; sharp, its higher modes and the stick."""
    t = time(0.9 * length)
    body = sweep(t, pitch_hz, 0.45 * pitch_hz, 0.06) * decay(t, 0.3 * length)
    # 1.59, 2.14, 2.65: the ratios of a round membrane's modes, zeros of Bessel functions.
    modes = np.zeros_like(t)
    for ratio in (1.59, 2.14, 2.65, 3.5):
        mode = sweep(t, ratio * pitch_hz, 0.4 * pitch_hz, 0.05)
        modes += mode * decay(t, 0.26 * length / ratio) / ratio
    stick = band(rng, t, 1200.0, 7000.0) * decay(t, 0.007)
    slap = band(rng, t, 400.0, 1800.0) * decay(t, 0.03)
    return layers(body, 0.4 * body * decay(t, 0.16) + modes + 0.5 * stick + 0.3 * slap)


def _hat(rng: Rng, seconds: float, ring_s: float) -> Layers:
    """Many partials that belong to no scale, in noise."""
    t = time(seconds)
    dark = metal(rng, t, 2200.0, 6500.0) + 0.5 * band(rng, t, 2500.0, 6500.0)
    bright = metal(rng, t, 6500.0, 14_000.0) + 0.8 * band(rng, t, 7500.0, 16_000.0)
    ring, tick = decay(t, ring_s), decay(t, 0.008)
    return layers(dark * ring + 0.4 * dark * tick, bright * ring + 0.6 * bright * tick)


def layers(deep: Wave, sharp: Wave) -> Layers:
    """Return both layers with soft ends and a peak of 1."""
    return Layers(_finished(deep), _finished(sharp))


def time(seconds: float) -> Wave:
    """Sample times, s."""
    return np.arange(round(seconds * RATE)) / RATE


def decay(t: Wave, seconds: float) -> Wave:
    """Exponential decay to 1/e in `seconds`."""
    faded: Wave = np.exp(-t / seconds)
    return faded


def driven(wave: Wave) -> Wave:
    """Soft clipping, as in an overdriven amplifier: adds overtones that small speakers can play."""
    rounded: Wave = np.tanh(wave)
    return rounded


def sine(t: Wave, hz: float) -> Wave:
    """A pure tone."""
    tone: Wave = np.sin(2 * np.pi * hz * t)
    return tone


def sweep(t: Wave, hz: float, above_hz: float, seconds: float) -> Wave:
    """A tone that starts `above_hz` higher and falls to `hz`."""
    turns = hz * t + above_hz * seconds * (1 - np.exp(-t / seconds))
    tone: Wave = np.sin(2 * np.pi * turns)
    return tone


def band(rng: Rng, t: Wave, low_hz: float, high_hz: float) -> Wave:
    """Band-limited noise with a standard deviation of 0.4."""
    spectrum = np.fft.rfft(rng.standard_normal(len(t)))
    hz = np.fft.rfftfreq(len(t), 1 / RATE) + 1e-9
    spectrum /= np.sqrt((1 + (low_hz / hz) ** 8) * (1 + (hz / high_hz) ** 8))
    noise: Wave = np.fft.irfft(spectrum, len(t))
    return noise * (0.4 / float(noise.std()))


def metal(rng: Rng, t: Wave, low_hz: float, high_hz: float, partials: int = 24) -> Wave:
    """Random tones between two pitches, with a standard deviation of 0.4."""
    hz = np.exp(rng.uniform(np.log(low_hz), np.log(high_hz), partials))
    phase = rng.uniform(0, 2 * np.pi, partials)
    tones: Wave = np.sin(2 * np.pi * hz[:, None] * t + phase[:, None]).sum(axis=0)
    return tones * (0.4 / float(tones.std()))


def _finished(wave: Wave) -> Wave:
    wave = wave.copy()
    rise, fall = round(ATTACK_S * RATE), round(RELEASE_S * RATE)
    wave[:rise] *= np.linspace(0.0, 1.0, rise, endpoint=False)
    wave[-fall:] *= np.linspace(1.0, 0.0, fall)
    return wave / float(np.abs(wave).max())
