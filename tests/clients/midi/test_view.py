"""The picture of a layout: the struck key lights up, and fingers are where they are."""

from __future__ import annotations

import os
from typing import Any

import pytest

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")

import pygame

from halo_client import PictureTransform
from halo_midi.layouts import LAYOUTS, board
from halo_midi.view import FINGER, SOUNDING, draw
from halo_window import Placed

SIZE = (600, 400)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_touching_finger_lights_its_key(wire: Any, layout: str) -> None:
    pygame.font.init()
    screen, keys = pygame.Surface(SIZE), board(layout)
    placed = Placed(PictureTransform.fitted(*SIZE, 300.0, 200.0), 300.0, 200.0)
    hovering, touching = wire.finger(2, at=(60.0, 60.0), hover_mm=20.0), wire.finger(pressure=0.5)
    draw(screen, placed, keys, (touching, hovering), "waiting for frames ...")
    left, _, _, near = keys.key(touching.u, touching.v).area
    corner = tuple(screen.get_at((round(600 * left) + 4, round(400 * near) - 4)))[:3]
    assert (corner == SOUNDING) == (not keys.layout.continuous)
    assert tuple(screen.get_at((300, 200)))[:3] == FINGER
    assert tuple(screen.get_at((120, 120)))[:3] != FINGER, "a hovering finger is a ring"
