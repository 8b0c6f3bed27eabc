"""The window.

Rule: pygame's window and its events, nothing of what is drawn. Full screen means the projector:
then the picture goes through the homography as soon as the service tells one.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Self

import pygame

from halo_client import KnownServices, PictureTransform
from halo_client.picture import HEIGHT_MM, WIDTH_MM

SIZE = (1200, 800)
MARGIN = 0.02
UNSEEN = ("dummy", "offscreen")
"""What SDL falls back to by itself where there is no screen; who wants that says so."""


class StageError(Exception):
    """There is nowhere to draw. The message is meant for the user."""


@dataclass(frozen=True, slots=True)
class Placed:
    """Where the surface is in the picture, and how large it is."""

    placing: PictureTransform
    width_mm: float
    height_mm: float


class Stage:
    """A window, or a whole display. A context manager; `StageError` where there is none."""

    def __init__(self, title: str, full_screen: bool = False, display: int = 0) -> None:
        try:
            pygame.display.init()
            pygame.font.init()
            if pygame.display.get_driver() in UNSEEN and "SDL_VIDEODRIVER" not in os.environ:
                raise pygame.error("none was found")
            count = pygame.display.get_num_displays()
            if not 0 <= display < count:
                raise StageError(f"there is no display {display}; there are 0 to {count - 1}")
            size = pygame.display.get_desktop_sizes()[display] if full_screen else SIZE
            flags = pygame.FULLSCREEN if full_screen else pygame.RESIZABLE
            self.screen = pygame.display.set_mode(size, flags, display=display)
        except pygame.error as error:
            pygame.quit()
            raise StageError(
                f"no display to draw on ({error}); run this where there is a screen"
            ) from error
        pygame.display.set_caption(title)
        pygame.mouse.set_visible(not full_screen)
        self._full_screen = full_screen
        self.open = True
        """False once the user has closed it."""

    def pressed(self) -> list[int]:
        """The keys pressed since the last call; sees to closing and resizing."""
        pressed = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                self.open = False
            elif event.type == pygame.KEYDOWN:
                pressed.append(event.key)
                self.open = self.open and event.key not in (pygame.K_ESCAPE, pygame.K_q)
        self.screen = pygame.display.get_surface() or self.screen
        return pressed

    def placed(self, known: KnownServices) -> Placed:
        """Where the surface is, by the latest that a service told."""
        scene = next(reversed(known.scenes.values()), None)
        size = (scene.width_mm, scene.height_mm) if scene else (WIDTH_MM, HEIGHT_MM)
        width, height = self.screen.get_size()
        homography = next(reversed(known.homographies.values()), None)
        if self._full_screen and homography is not None:
            return Placed(PictureTransform.projected(homography, width, height), *size)
        margin = 0.0 if self._full_screen else MARGIN * height
        return Placed(PictureTransform.fitted(width, height, *size, margin), *size)

    def show(self) -> None:
        """Let what was drawn be seen."""
        pygame.display.flip()

    def close(self) -> None:
        """Close the window. May be called twice."""
        self.open = False
        pygame.quit()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
