"""The layout as a picture: keys, and the notes that sound.

Rule: draws on any pygame surface; reads no clock.
"""

from __future__ import annotations

from functools import lru_cache

import pygame

from halo_midi.layouts import Board, Key, note_name
from halo_protocol import Pointer
from halo_window import Placed

BACKGROUND, LINE, TEXT = (14, 14, 18), (90, 96, 110), (235, 235, 235)
NATURAL, SHARP, SOUNDING = (44, 48, 58), (24, 26, 32), (240, 190, 80)
FINGER = (120, 200, 255)
FINGER_MM = 6.0


def draw(
    screen: pygame.Surface,
    placed: Placed,
    board: Board,
    pointers: tuple[Pointer, ...],
    note: str = "",
) -> None:
    """Draw keys and fingers; `note` is a line of text at the lower edge."""
    screen.fill(BACKGROUND)
    font = _font(max(16, screen.get_height() // 34))
    pressed = {board.key(each.u, each.v).area for each in pointers if each.touching}
    # The first key that has a place counts, so it is drawn last.
    for key in reversed(board.keys):
        _key(screen, placed, font, key, key.area in pressed, board.layout.continuous)
    if board.layout.continuous:
        _octaves(screen, placed, font, board)
    for pointer in pointers:
        at = placed.placing.pixel(pointer.x_mm, pointer.y_mm)
        radius = FINGER_MM + (0.0 if pointer.touching else pointer.hover_mm / 4)
        size = radius * placed.placing.scale(pointer.x_mm, pointer.y_mm)
        pygame.draw.aacircle(screen, FINGER, at, size, 0 if pointer.touching else 2)
    if note:
        words = font.render(note, True, TEXT)
        screen.blit(words, (12, screen.get_height() - words.get_height() - 8))


def _key(
    screen: pygame.Surface,
    placed: Placed,
    font: pygame.font.Font,
    key: Key,
    sounds: bool,
    continuous: bool,
) -> None:
    left, far, right, near = key.area
    corners = [
        placed.placing.pixel(u * placed.width_mm, v * placed.height_mm)
        for u, v in ((left, far), (right, far), (right, near), (left, near))
    ]
    name = note_name(key.note)
    colour = SOUNDING if sounds and not continuous else SHARP if "#" in name else NATURAL
    pygame.draw.polygon(screen, colour, corners)
    pygame.draw.aalines(screen, LINE, True, corners)
    if not continuous:
        words = font.render(name, True, BACKGROUND if sounds else TEXT)
        x, y = placed.placing.pixel(
            (left + right) / 2 * placed.width_mm, (far + 5 * near) / 6 * placed.height_mm
        )
        screen.blit(words, words.get_rect(center=(x, y)))


def _octaves(screen: pygame.Surface, placed: Placed, font: pygame.font.Font, board: Board) -> None:
    """A line at each C of a layout without keys."""
    for note in range(board.root, board.root + round(board.layout.semitones) + 1):
        if note % 12 == 0:
            x_mm = (note - board.root) / board.layout.semitones * placed.width_mm
            far, near = (placed.placing.pixel(x_mm, y) for y in (0.0, placed.height_mm))
            pygame.draw.aaline(screen, LINE, far, near)
            screen.blit(font.render(note_name(note), True, TEXT), (near[0] + 6, near[1] - 24))


@lru_cache(maxsize=4)
def _font(height_px: int) -> pygame.font.Font:
    """Load the font once, not for each picture."""
    return pygame.font.Font(None, height_px)
