"""A recorded stream as a file of sound, exact to the sample.

Rule: no clock, no device. A hit starts at the time of the touch (frame time minus
`ago_ms`). Live, it starts when its frame arrives.
"""

from __future__ import annotations

import wave
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halo_client.files import appearing
from halo_drums.bank import make_bank
from halo_drums.kit import KIT, Pad, Settings
from halo_drums.mixer import BLOCK, Mixer
from halo_drums.player import Gesture, Player
from halo_drums.voices import RATE
from halo_protocol import TouchFrame

TAIL_S = 1.5
"""Time for the last hit to decay."""


def render(
    frames: Iterable[TouchFrame],
    kit: tuple[Pad, ...] = KIT,
    settings: Settings | None = None,
) -> NDArray[np.float32]:
    """Return (N, 2) float32 samples; sample 0 is at the first frame's time."""
    player = Player(kit, settings)
    gestures: list[Gesture] = []
    first_us = last_us = None
    for frame in frames:
        first_us = frame.time_us if first_us is None else first_us
        last_us = frame.time_us
        gestures += player.process(frame)
    if first_us is None or last_us is None:
        return np.zeros((0, 2), np.float32)
    mixer = Mixer(make_bank(kit), settings or Settings())
    length = round((last_us - first_us) * RATE / 1e6 + TAIL_S * RATE)
    due = sorted(((_sample(each, first_us), each) for each in gestures), key=lambda pair: pair[0])
    blocks, next_one = [], 0
    for start in range(0, length, BLOCK):
        while next_one < len(due) and due[next_one][0] < start + BLOCK:
            at, gesture = due[next_one]
            mixer.apply(gesture, at - start)
            next_one += 1
        blocks.append(mixer.block())
    return np.concatenate(blocks)[:length]


def write_wav(path: Path, sound: NDArray[np.float32]) -> None:
    """Write a WAV file, 16 bits, stereo. Raises `OSError`."""
    # Not wave.open(path): it prints a traceback of its own if the path cannot be opened.
    with appearing(path) as raw, wave.open(raw, "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(np.round(sound * 32_767).astype("<i2").tobytes())


def _sample(gesture: Gesture, first_us: int) -> int:
    return max(0, round((gesture.time_us - first_us) * RATE / 1e6))
