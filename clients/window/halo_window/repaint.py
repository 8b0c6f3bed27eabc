"""Draws again only what changed: a background, and what the last picture drew over it.

Rule: pygame surfaces and rectangles, no window. A whole picture of 1920x1080 costs several
milliseconds to copy and to show; a finger and a key cost nearly nothing.
"""

from __future__ import annotations

import pygame


class Repaint:
    """The changed parts of one picture: `restore`, draw and call `over`, then show `parts`."""

    def __init__(self) -> None:
        self._size: tuple[int, int] | None = None
        self._over: list[pygame.Rect] = []
        self._changed: list[pygame.Rect] = []
        self._parts: list[pygame.Rect] | None = None

    def changed(self, part: pygame.Rect | None = None) -> None:
        """Note that the background has changed there; None: everywhere."""
        if part is None:
            self._size = None
        else:
            self._changed.append(part)

    def restore(self, screen: pygame.Surface, background: pygame.Surface) -> list[pygame.Rect]:
        """Copy the background where it changed or was drawn over; return these parts."""
        bounds = screen.get_rect()
        if self._size == bounds.size:
            parts = [part.clip(bounds) for part in (*self._changed, *self._over)]
            parts = [part for part in parts if part.w and part.h]
        else:
            parts = [bounds]
        self._size = bounds.size
        self._changed, self._over, self._parts = [], [], parts
        for part in parts:
            screen.blit(background, part, part)
        return list(parts)

    def over(self, part: pygame.Rect) -> None:
        """Note that something was drawn over the background there."""
        self._over.append(part.inflate(2, 2))

    @property
    def parts(self) -> list[pygame.Rect]:
        """The parts of the screen that differ from the last picture."""
        return [*(self._parts or ()), *self._over]
