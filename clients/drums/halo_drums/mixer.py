"""From gestures to sound, a block at a time.

Rule: pure and without a clock; used by one thread only. Each value that changes within a
block is ramped from its old value, so that nothing clicks.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halo_client import TouchKey
from halo_drums.bank import Bank, Sample
from halo_drums.kit import Pad, Settings
from halo_drums.player import Gesture, Hit, Press, Release, Shape
from halo_drums.voices import RATE

BLOCK = 256
"""Samples per block, 5.3 ms."""
VOICES = 24
"""Sounds at the same time; one more fades the oldest out."""
LEVEL = 0.8
"""Level of one loud hit before the limiter."""
CEILING = 0.97
"""Upper limit of all peaks."""
TUNING = 5.0
"""Semitones between the lowest hand and the highest."""
BRIGHTNESS = 0.3
"""How much sharper the hardest strike is than the softest, over the hand's whole height."""
FADE_S = 0.012
"""Fade-out time of a sound that is choked or replaced."""
GLIDE_S = 0.03
"""Time constant with which the sound follows the hand; the camera sees it 30 times a second."""

Block = NDArray[np.float32]
"""(BLOCK, 2): left, right, within -1 to 1."""

_STEPS = np.arange(1, BLOCK + 1, dtype=np.float32) / BLOCK


@dataclass(slots=True)
class _Voice:
    """A sample that sounds."""

    key: TouchKey
    pad: Pad
    sample: Sample
    level: float
    mix: tuple[float, float]
    """Gain of the deep and the sharp layer at the end of the last block."""
    rate: float
    """Playback rate at the end of the last block; 1 is the original pitch."""
    gain: float = 1.0
    """Gain after press and choke, at the end of the last block."""
    at: float = 0.0
    """Position in the sample."""
    wait: int = 0
    """Output samples until it starts."""
    pressed: float = 0.0
    fading: bool = False


@dataclass(slots=True)
class Mixer:
    """All voices."""

    bank: Bank
    settings: Settings = field(default_factory=Settings)
    _voices: list[_Voice] = field(default_factory=list)
    _height: float = 0.0
    _target: float = 0.0
    _hits: int = 0

    def __post_init__(self) -> None:
        self._height = self._target = self.settings.resting

    @property
    def sounding(self) -> int:
        """Number of active voices."""
        return len(self._voices)

    def apply(self, gesture: Gesture, offset: int = 0) -> None:
        """Apply a gesture; a hit starts `offset` samples after the start of the next block."""
        if isinstance(gesture, Hit):
            self._strike(gesture, offset)
        elif isinstance(gesture, Shape):
            self._target = gesture.height
        else:
            amount = gesture.amount if isinstance(gesture, Press) else 0.0
            for voice in self._voices:
                # A mute stays when the finger leaves; a bend goes back.
                if voice.key == gesture.key and not isinstance(gesture, Release):
                    voice.pressed = amount
                elif voice.key == gesture.key and voice.pad.mute < 1.0:
                    voice.pressed = 0.0

    def block(self) -> Block:
        """Return the next samples."""
        self._height += (self._target - self._height) * (1 - np.exp(-BLOCK / (GLIDE_S * RATE)))
        out = np.zeros((BLOCK, 2), np.float32)
        for voice in self._voices:
            self._add(voice, out)
        self._voices = [voice for voice in self._voices if not _ended(voice)]
        limited: Block = CEILING * np.tanh(out)
        return limited

    def _strike(self, hit: Hit, offset: int) -> None:
        for voice in self._voices:
            if voice.pad.name in hit.pad.chokes or (
                voice.pad.name == hit.pad.name and voice.pressed
            ):
                voice.fading = True
        active = [voice for voice in self._voices if not voice.fading]
        for voice in active[: max(0, len(active) - VOICES + 1)]:
            voice.fading = True
        samples = self.bank[hit.pad.name]
        self._hits += 1
        sample = samples[self._hits % len(samples)]
        voice = _Voice(hit.key, hit.pad, sample, hit.level, (0.0, 0.0), 1.0)
        voice.mix, voice.rate, voice.wait = self._mix(voice), self._rate(voice), offset
        self._voices.append(voice)

    def _mix(self, voice: _Voice) -> tuple[float, float]:
        """Gains of both layers: equal power, so that the hand changes timbre, not loudness."""
        sharp = self._height + BRIGHTNESS * (voice.level - 0.6)
        angle = np.pi / 2 * min(max(sharp, 0.0), 1.0)
        return float(np.cos(angle)), float(np.sin(angle))

    def _rate(self, voice: _Voice) -> float:
        semitones = TUNING * (self._height - 0.5) + voice.pad.bend * voice.pressed
        return float(2 ** (semitones / 12))

    def _gain(self, voice: _Voice) -> float:
        if voice.fading:
            return max(0.0, voice.gain - BLOCK / (FADE_S * RATE))
        target = 1 - voice.pad.mute * min(voice.pressed, 1.0)
        return voice.gain + 0.35 * (target - voice.gain)

    def _add(self, voice: _Voice, out: Block) -> None:
        mix, rate, gain = self._mix(voice), self._rate(voice), self._gain(voice)
        steps = _STEPS[: BLOCK - voice.wait]
        places = voice.at + np.cumsum(voice.rate + (rate - voice.rate) * steps, dtype=np.float64)
        # The first output sample is the sample's own value; later ones are interpolated.
        places -= places[0] - voice.at
        inside = places[places < len(voice.sample) - 1]
        whole = inside.astype(np.intp)
        part = (inside - whole).astype(np.float32)[:, None]
        both = voice.sample[whole] * (1 - part) + voice.sample[whole + 1] * part
        ramp = steps[: len(inside), None]
        deep = voice.mix[0] + (mix[0] - voice.mix[0]) * ramp
        sharp = voice.mix[1] + (mix[1] - voice.mix[1]) * ramp
        loud = LEVEL * voice.level * (voice.gain + (gain - voice.gain) * ramp)
        out[voice.wait : voice.wait + len(inside)] += loud * (
            deep * both[:, :2] + sharp * both[:, 2:]
        )
        voice.at = float(places[-1] + rate)
        voice.mix, voice.rate, voice.gain, voice.wait = mix, rate, gain, 0


def _ended(voice: _Voice) -> bool:
    return voice.at >= len(voice.sample) - 1 or (voice.fading and voice.gain <= 0.0)
