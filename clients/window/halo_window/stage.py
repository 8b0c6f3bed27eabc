"""The window.

Rule: pygame's window and its events, no drawing. Full screen means the projector: the picture
then uses the homography, once the service has sent one.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import pygame

from halo_client import KnownServices, PictureTransform
from halo_client.follow import Key
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_window.errors import StageError

SIZE = (1200, 800)
MARGIN = 0.02
WITHOUT_DISPLAY = ("dummy", "offscreen")
"""SDL's fallback drivers without a screen; accepted only if SDL_VIDEODRIVER names one."""
WHOLE = (pygame.VIDEOEXPOSE, pygame.WINDOWEXPOSED, pygame.WINDOWSIZECHANGED)
"""Events after which the system may have lost the picture."""


@dataclass(frozen=True, slots=True)
class Placed:
    """The place of the surface in the picture, and its size."""

    placing: PictureTransform
    width_mm: float
    height_mm: float


class Stage:
    """A window or a full display; a context manager. Raises `StageError` without a display."""

    def __init__(self, title: str, full_screen: bool = False, display: int = 0) -> None:
        try:
            # On a scaled desktop of Windows, sizes are then pixels of the projector.
            os.environ.setdefault("SDL_WINDOWS_DPI_AWARENESS", "permonitorv2")
            pygame.display.init()
            pygame.font.init()
            if (
                pygame.display.get_driver() in WITHOUT_DISPLAY
                and "SDL_VIDEODRIVER" not in os.environ
            ):
                raise pygame.error("none was found")
            count = pygame.display.get_num_displays()
            if not 0 <= display < count:
                raise StageError(f"there is no display {display}; choose from 0 to {count - 1}")
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
        self._exposed = True
        self.open = True
        """False after the user has closed the window."""

    def pressed(self) -> list[int]:
        """Return the keys pressed since the last call; handle closing and resizing."""
        pressed = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                self.open = False
            elif event.type == pygame.KEYDOWN:
                pressed.append(event.key)
                self.open = self.open and event.key not in (pygame.K_ESCAPE, pygame.K_q)
            elif event.type in WHOLE:
                self._exposed = True
        self.screen = pygame.display.get_surface() or self.screen
        return pressed

    def placed(self, known: KnownServices, following: Key | None = None) -> Placed:
        """Return the place of the surface, by scene and homography of the service that is followed.

        `following`: see `Receiver.following`; None: the service with the newest report.
        """
        scene, homography = known.placing(following)
        size = (scene.width_mm, scene.height_mm) if scene else (WIDTH_MM, HEIGHT_MM)
        width, height = self.screen.get_size()
        if self._full_screen and homography is not None:
            return Placed(PictureTransform.projected(homography, width, height), *size)
        margin = 0.0 if self._full_screen else MARGIN * height
        return Placed(PictureTransform.fitted(width, height, *size, margin), *size)

    def show(self, parts: Sequence[pygame.Rect] | None = None) -> None:
        """Show what was drawn; `parts`: all that differs from the last picture, None: unknown."""
        if parts is None or self._exposed:
            pygame.display.flip()
        else:
            pygame.display.update(parts)
        self._exposed = False

    def close(self) -> None:
        """Close the window. May be called twice."""
        self.open = False
        pygame.quit()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
