"""Whether painting is fast enough: two fingers with the widest brush, pictures at 1920x1080.

Every two seconds a stroke ends, a colour is chosen and the next one begins.

SDL_VIDEODRIVER=dummy uv run python benchmarks/paint.py
"""

from __future__ import annotations

import math
import time

import numpy as np
import pygame

from halo_client import PictureTransform
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_paint.brushes import BRUSHES
from halo_paint.painter import Painter
from halo_paint.view import View
from halo_protocol import Down, Pointer, TouchFrame, Up
from halo_window import Placed

SIZE = (1920, 1080)
STROKE, CHOICE = 60, 3
"""Frames of a stroke and the choice after it, and of the choice."""
PICTURES = 600
"""Ten seconds; every second picture has a new frame, as from a camera of thirty a second."""


def main() -> None:
    pygame.display.init()
    pygame.font.init()
    screen = pygame.display.set_mode(SIZE)
    placed = Placed(PictureTransform.fitted(*SIZE, WIDTH_MM, HEIGHT_MM), WIDTH_MM, HEIGHT_MM)
    view, painter = View(SIZE, placed), Painter(brush=BRUSHES[0])
    took_ms, worked_each_ms = [], []
    worked_s = time.process_time()
    for number in range(PICTURES):
        began_s, worked_now_s = time.perf_counter(), time.process_time()
        frame = _frame(number // 2)
        if number % 2 == 0:
            view.update(painter.process(frame), painter)
        view.draw(screen, painter, frame.pointers, "")
        pygame.display.update(view.parts)
        took_ms.append(1000 * (time.perf_counter() - began_s))
        worked_each_ms.append(1000 * (time.process_time() - worked_now_s))
    worked_ms = 1000 * (time.process_time() - worked_s) / PICTURES
    share, alone = (np.mean(np.array(each) < 1000 / 60) for each in (took_ms, worked_each_ms))
    print(
        f"a picture takes {np.median(took_ms):.1f} ms, p99 {np.percentile(took_ms, 99):.1f} ms "
        f"(16.7 ms are 60 a second); {100 * share:.1f} % in time; "
        f"{worked_ms:.1f} ms of one core each, at most {max(worked_each_ms):.1f} ms: "
        f"{100 * alone:.1f} % in time on an idle core"
    )


def _frame(number: int) -> TouchFrame:
    """Two fingers on circles, 150 mm/s, at full pressure; between two strokes, on the palette."""
    stroke, step = divmod(number, STROKE)
    contacts = 2 * stroke + (step >= STROKE - CHOICE)
    fingers = []
    for finger, middle in ((1, 100.0), (2, 200.0)):
        angle = number * 0.125
        x, y = middle + 40 * math.cos(angle), 100 + 40 * math.sin(angle)
        if contacts % 2 == 1:
            x, y = 5.0, 20.0 + 40.0 * (stroke % 4)
        place = (x / WIDTH_MM, y / HEIGHT_MM, x, y)
        fingers.append(
            Pointer(finger, finger, 2, 1, 1, *place, 0.0, 1.8, 0.0, 0.0, 0.9, contacts, -1.0)
        )
    if step not in (0, STROKE - CHOICE):
        return TouchFrame("table", "bench", "s", number, number * 33_333, tuple(fingers))
    downs = tuple(
        Down(each.id, each.slot, each.u, each.v, 200.0, 0.0, contacts) for each in fingers
    )
    ups = tuple(Up(each.id, each.slot, each.u, each.v, 0.0, contacts - 1) for each in fingers)
    ups = ups if number else ()
    return TouchFrame("table", "bench", "s", number, number * 33_333, tuple(fingers), downs, ups)


if __name__ == "__main__":
    main()
