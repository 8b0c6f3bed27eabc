"""A picture drawn in its changed parts equals one drawn as a whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pygame
import pytest

from halo_client import PictureTransform
from halo_drums.kit import KIT
from halo_drums.player import Hit, Player, Shape
from halo_drums.view import View as DrumsView
from halo_paint.painter import Painter
from halo_paint.view import View as PaintView
from halo_type.layout import load_layout
from halo_type.typist import Trial, Typist
from halo_type.view import View as TypeView
from halo_window import Placed, Repaint

SIZE = (240, 160)
PLACED = Placed(PictureTransform.fitted(*SIZE, 300.0, 200.0), 300.0, 200.0)
Draw = Callable[[pygame.Surface, Any, float], list[pygame.Rect]]


def drums() -> Draw:
    view, player = DrumsView(KIT), Player()

    def draw(screen: pygame.Surface, frame: Any, now_s: float) -> list[pygame.Rect]:
        for gesture in player.process(frame):
            if isinstance(gesture, Hit | Shape):
                view.update(gesture, now_s)
        view.draw(screen, PLACED, now_s, "waiting" if 0.4 < now_s < 0.6 else "")
        return view.parts

    return draw


def paint() -> Draw:
    view, painter = PaintView(SIZE, PLACED), Painter()

    def draw(screen: pygame.Surface, frame: Any, now_s: float) -> list[pygame.Rect]:
        view.update(painter.process(frame), painter)
        view.draw(screen, painter, frame.pointers, "waiting" if 0.4 < now_s < 0.6 else "")
        return view.parts

    return draw


def typing() -> Draw:
    view, typist = TypeView(), Typist(load_layout("qwerty"), [Trial("t", 1, "a word")])

    def draw(screen: pygame.Surface, frame: Any, now_s: float) -> list[pygame.Rect]:
        for struck in typist.process(frame):
            view.update(struck, now_s)
        note = "waiting" if 0.4 < now_s < 0.6 else ""
        view.draw(screen, PLACED, typist.shown, frame.pointers, now_s, note)
        return view.parts

    return draw


def stream(wire: Any) -> list[Any]:
    """One finger touches three times, on its way across the surface, the palette among them."""
    frames, contacts = [], 0
    for number in range(45):
        at = (10.0 + 6.5 * number, 80.0 + 30.0 * np.sin(number / 5))
        touching, events = number % 15 < 8, {}
        if number % 15 == 0:
            contacts += 1
            events["downs"] = (wire.down(at=at, contacts=contacts, ago_ms=0.0),)
        elif number % 15 == 8:
            events["ups"] = (wire.up(at=at, contacts=contacts),)
        pressure = 0.2 + 0.1 * (number % 15) if touching else None
        finger = wire.finger(at=at, pressure=pressure, hover_mm=6.0, contacts=contacts)
        other = wire.finger(2, hand=1, at=(40.0, 150.0), hover_mm=8.0 + number, contacts=0)
        frames.append(wire.frame(number, [finger, other], **events))
    return frames


@pytest.mark.parametrize("view", [drums, paint, typing])
def test_parts_of_a_picture_give_the_whole_picture(view: Callable[[], Draw], wire: Any) -> None:
    pygame.font.init()
    in_parts, whole_view = view(), view()
    screen, shown = pygame.Surface(SIZE, depth=32), pygame.Surface(SIZE, depth=32)
    shares = []
    for number, frame in enumerate(stream(wire)):
        parts = in_parts(screen, frame, number / 30)
        for part in parts:
            shown.blit(screen, part, part)
        whole = pygame.Surface((SIZE[0] + number % 2, SIZE[1]), depth=32)  # another size: all anew
        whole_view(whole, frame, number / 30)
        expected = pygame.surfarray.array3d(whole)[: SIZE[0]]
        assert np.array_equal(pygame.surfarray.array3d(screen), expected), number
        assert np.array_equal(pygame.surfarray.array3d(shown), expected), number
        shares.append(sum(part.w * part.h for part in parts) / (SIZE[0] * SIZE[1]))
    assert shares[0] >= 1.0
    assert np.median(shares[1:]) < 0.5


def test_what_was_drawn_over_the_background_is_gone_in_the_next_picture() -> None:
    screen, background = pygame.Surface((20, 20), depth=32), pygame.Surface((20, 20), depth=32)
    repaint = Repaint()
    assert repaint.restore(screen, background) == [screen.get_rect()]
    repaint.over(screen.fill("red", (5, 5, 4, 4)))
    assert repaint.restore(screen, background) == [pygame.Rect(4, 4, 6, 6)]
    assert not pygame.surfarray.array3d(screen).any()
    assert repaint.restore(screen, background) == []
    repaint.over(screen.fill("red", (18, 18, 4, 4)))
    repaint.changed(pygame.Rect(40, 40, 5, 5))
    assert repaint.restore(screen, background) == [pygame.Rect(17, 17, 3, 3)]
