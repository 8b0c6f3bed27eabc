"""The typist's picture: the phrase, the text with its cursor, and the keys.

Rule: draws on any pygame surface; reads no clock. The keyboard is drawn once for each size.
"""

from __future__ import annotations

from collections.abc import Sequence

import pygame

from halo_protocol import Pointer
from halo_type.layout import SPACE, Key
from halo_type.typist import Shown, Struck
from halo_window import Placed, Repaint

BACKGROUND, KEY, EDGE = (14, 14, 18), (38, 40, 52), (86, 90, 110)
INK, TEXT, FAINT, STRUCK = (235, 235, 240), (255, 235, 150), (150, 152, 165), (70, 190, 190)
GLOW_S = 0.25
"""How long a key glows after a touch."""
GAP_MM = 0.7
"""Between two keys, on each side."""
NEAR_MM = 25.0
"""Below this height, a ring shows where the finger is."""
BLINK_S = 1.0
LINES = ((0.05, 0.035), (0.135, 0.055), (0.225, 0.055))
"""Place and height of each line of text over the surface's height: figures, phrase, text."""
FITS = 44
"""Characters in a line of this height; a longer phrase is smaller."""


class View:
    """The picture of a session."""

    def __init__(self) -> None:
        self._glowing: dict[str, float] = {}
        self._board: pygame.Surface | None = None
        self._drawn_for: object = None
        self._repaint = Repaint()

    @property
    def parts(self) -> list[pygame.Rect]:
        """The parts of the screen that differ from the last picture."""
        return self._repaint.parts

    def update(self, struck: Struck, now_s: float) -> None:
        """Let a key glow."""
        if struck.character is not None:
            self._glowing[struck.character] = now_s

    def draw(
        self,
        screen: pygame.Surface,
        placed: Placed,
        shown: Shown,
        fingers: Sequence[Pointer],
        now_s: float,
        note: str = "",
    ) -> None:
        """Draw what changed; `note` is a line of text at the lower edge."""
        drawn_for = screen.get_size(), placed, shown.keys
        if self._board is None or self._drawn_for != drawn_for:
            self._board, self._drawn_for = self._keyboard(screen, placed, shown.keys), drawn_for
            self._repaint.changed()
        self._repaint.restore(screen, self._board)
        for character, at_s in list(self._glowing.items()):
            light = 1.0 - (now_s - at_s) / GLOW_S
            if light <= 0.0 or character not in shown.keys:
                del self._glowing[character]
            else:
                colour = pygame.Color(*KEY).lerp(pygame.Color(*STRUCK), light)
                self._repaint.over(_key(screen, placed, shown.keys[character], colour))
        self._text(screen, placed, shown, now_s)
        for finger in fingers:
            if not finger.touching and finger.hover_mm < NEAR_MM:
                self._repaint.over(_ring(screen, placed, finger))
        if note:
            words = _font(max(18, screen.get_height() // 24)).render(note, True, FAINT)
            place = (12, screen.get_height() - words.get_height() - 8)
            self._repaint.over(screen.blit(words, place))

    def _keyboard(
        self, screen: pygame.Surface, placed: Placed, keys: dict[str, Key]
    ) -> pygame.Surface:
        board = pygame.Surface(screen.get_size(), 0, screen)
        board.fill(BACKGROUND)
        for key in keys.values():
            _key(board, placed, key, pygame.Color(*KEY))
        return board

    def _text(self, screen: pygame.Surface, placed: Placed, shown: Shown, now_s: float) -> None:
        left_mm = min((key.x_mm for key in shown.keys.values()), default=0.0)
        trial = shown.trial
        presented = "all phrases are done" if trial is None else trial.presented
        fits = max(FITS, len(presented))
        cursor = "|" if trial is not None and now_s % BLINK_S < BLINK_S / 2 else ""
        lines = (
            (state_of(shown), FAINT),
            (presented, INK),
            (shown.text[-fits:] + cursor, TEXT),
        )
        for (line, colour), (top, height) in zip(lines, LINES, strict=True):
            x, y = placed.placing.pixel(left_mm, top * placed.height_mm)
            scale = placed.placing.scale(left_mm, top * placed.height_mm)
            font = _font(max(12, round(height * placed.height_mm * scale * FITS / fits)))
            self._repaint.over(screen.blit(font.render(line, True, colour), (x, y)))


def state_of(shown: Shown) -> str:
    """The task, and how the last phrase went."""
    parts = [] if shown.trial is None else [f"{shown.trial.task} {shown.trial.number}"]
    if shown.last is not None:
        done = shown.last.typed
        parts.append(
            f"last phrase: {done.wpm:.0f} words a minute, {100 * done.accuracy:.0f} % right"
        )
    return "    ".join(parts)


def name_of(key: Key) -> str:
    """What is written on a key."""
    return "" if key.character == SPACE else key.character


def _key(screen: pygame.Surface, placed: Placed, key: Key, colour: pygame.Color) -> pygame.Rect:
    left, top = key.x_mm + GAP_MM, key.y_mm + GAP_MM
    right, low = key.x_mm + key.width_mm - GAP_MM, key.y_mm + key.height_mm - GAP_MM
    corners = [
        placed.placing.pixel(*at) for at in ((left, top), (right, top), (right, low), (left, low))
    ]
    area = pygame.draw.polygon(screen, colour, corners)
    edge = pygame.draw.aalines(screen, EDGE, True, corners)
    scale = placed.placing.scale(*key.middle)
    share = 0.5 if len(key.character) == 1 else 0.32
    words = _font(max(10, round(share * key.height_mm * scale))).render(name_of(key), True, INK)
    place = words.get_rect(center=placed.placing.pixel(*key.middle))
    return area.unionall([edge, screen.blit(words, place)])


def _ring(screen: pygame.Surface, placed: Placed, finger: Pointer) -> pygame.Rect:
    at = finger.x_mm, finger.y_mm
    scale = placed.placing.scale(*at)
    radius = (2.0 + 0.3 * finger.hover_mm) * scale
    return pygame.draw.aacircle(screen, STRUCK, placed.placing.pixel(*at), radius, 2)


_fonts: dict[int, pygame.font.Font] = {}


def _font(height_px: int) -> pygame.font.Font:
    """Load each font once, not for each picture."""
    if height_px not in _fonts:
        _fonts[height_px] = pygame.font.Font(None, height_px)
    return _fonts[height_px]
