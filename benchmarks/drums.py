"""How the drums keep up: a minute on a sound device that nobody hears, as busy as hands can be.

uv run python benchmarks/drums.py [SECONDS]
"""

from __future__ import annotations

import sys
import time

import miniaudio
import numpy as np

from halo_client import TouchKey
from halo_drums.bank import make_bank
from halo_drums.kit import KIT
from halo_drums.mixer import BLOCK, Mixer
from halo_drums.player import Hit, Shape
from halo_drums.speakers import Speakers
from halo_drums.voices import RATE

HITS_HZ = 12.0
"""Both hands, as fast as it goes."""


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    bank = make_bank(KIT)
    print(f"a full mixer: {_full_block(bank):.2f} ms for {1000 * BLOCK / RATE:.2f} ms of sound")
    with Speakers(Mixer(bank), [miniaudio.Backend.NULL]) as speakers:
        for number in range(round(seconds * HITS_HZ)):
            pad = KIT[number % len(KIT)]
            key = TouchKey("bench", "table", "s", 1, number)
            speakers.send(Hit(0, key, pad, 0.5 + 0.5 * (number % 2), 0.5, 0.5))
            speakers.send(Shape(0, 0.5 + 0.5 * float(np.sin(number / 9))))
            time.sleep(1 / HITS_HZ)
        print(
            f"{speakers.made_s:.1f} s played, {speakers.gaps} gaps; the slowest piece took "
            f"{100 * speakers.slowest:.0f} % of its time"
        )


def _full_block(bank: dict[str, list[np.ndarray]]) -> float:
    mixer = Mixer(bank)
    for number in range(24):
        mixer.take(Hit(0, TouchKey("b", "t", "s", 1, number), KIT[number % 4], 1.0, 0.5, 0.5))
    began_s = time.perf_counter()
    for _ in range(50):
        mixer.block()
    return (time.perf_counter() - began_s) / 50 * 1000


if __name__ == "__main__":
    main()
