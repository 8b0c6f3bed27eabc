"""Whether the drums are fast enough: a minute on a null sound device, at the fastest drumming.

uv run python benchmarks/drums.py [SECONDS]

In parallel, a second process runs the same device without hits: gaps there are caused by the
machine, not by the drums.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time

os.environ |= {"SDL_VIDEODRIVER": "dummy", "PYGAME_HIDE_SUPPORT_PROMPT": "1"}

import miniaudio
import numpy as np
import pygame

from halo_client import PictureTransform, TouchKey
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_drums.bank import Bank, make_bank
from halo_drums.kit import KIT
from halo_drums.mixer import BLOCK, Mixer
from halo_drums.player import Hit, Shape
from halo_drums.speakers import LATENCY_S, Speakers
from halo_drums.view import View
from halo_drums.voices import RATE
from halo_window import Placed

SIZE = (1920, 1080)
PICTURES_HZ = 60
HIT_EACH = 5
"""Pictures between two hits: 12 hits a second are two hands at full speed."""
CONTROL = "control"


def main() -> None:
    """Run both at once; the control is this program again."""
    if sys.argv[1:2] == [CONTROL]:
        run({}, float(sys.argv[2]), CONTROL)
        return
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    bank = make_bank(KIT)
    print(f"a full mixer: {full_block_ms(bank):.2f} ms for {1000 * BLOCK / RATE:.2f} ms of sound")
    print(f"the device buffers {1000 * LATENCY_S:.0f} ms; a longer delay is a gap")
    with subprocess.Popen([sys.executable, __file__, CONTROL, str(seconds)]):
        run(bank, seconds, "drums")


def run(bank: Bank, seconds: float, name: str) -> None:
    """Hits and pictures as in a window; neither for the control, which has no bank."""
    pygame.display.init()
    pygame.font.init()
    screen = pygame.display.set_mode(SIZE)
    placed = Placed(PictureTransform.fitted(*SIZE, WIDTH_MM, HEIGHT_MM), WIDTH_MM, HEIGHT_MM)
    view = View(KIT)
    took_ms = []
    with Speakers(Mixer(bank), [miniaudio.Backend.NULL]) as speakers:
        for picture in range(round(seconds * PICTURES_HZ)):
            began_s = time.perf_counter()
            if bank and picture % HIT_EACH == 0:
                number = picture // HIT_EACH
                key = TouchKey("bench", "table", "s", 1, number)
                loud = 0.5 + 0.5 * (number % 2)
                hit = Hit(0, key, KIT[number % len(KIT)], loud, 0.5, 0.5)
                for gesture in (hit, Shape(0, 0.5 + 0.5 * float(np.sin(number / 9)))):
                    speakers.send(gesture)
                    view.update(gesture, began_s)
            if bank:
                view.draw(screen, placed, began_s)
                pygame.display.update(view.parts)
            took_ms.append(1000 * (time.perf_counter() - began_s))
            time.sleep(max(0.0, began_s + 1 / PICTURES_HZ - time.perf_counter()))
        print(
            f"{name}: {speakers.made_s:.1f} s of sound, {speakers.gaps} gaps; a piece came at most "
            f"{1000 * speakers.latest_s:.0f} ms late, and the slowest took "
            f"{100 * speakers.slowest:.0f} % of its duration to compute"
        )
    if bank:
        share = np.mean(np.array(took_ms) < 1000 / PICTURES_HZ)
        print(
            f"{name}: a picture takes {np.median(took_ms):.1f} ms, p99 "
            f"{np.percentile(took_ms, 99):.1f} ms; {100 * share:.1f} % in time"
        )


def full_block_ms(bank: Bank) -> float:
    """Return the time of a block with all voices active, ms."""
    mixer = Mixer(bank)
    for number in range(24):
        mixer.apply(Hit(0, TouchKey("b", "t", "s", 1, number), KIT[number % 4], 1.0, 0.5, 0.5))
    began_s = time.perf_counter()
    for _ in range(50):
        mixer.block()
    return (time.perf_counter() - began_s) / 50 * 1000


if __name__ == "__main__":
    main()
