"""What shows a picture on the table: the projector's display, the virtual projector, or a file.

Rule: each is a `Screen` of the guided calibration.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.guided.projector import Screen
from halo_service.app.projector.display import Display
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.sources import Source

Picture = NDArray[np.uint8]

FILE_PX = (1920, 1080)
"""Size of the picture in a file where none is given: most projectors'."""


@dataclass(frozen=True, slots=True)
class ScreenRequest:
    """Where the user wants pictures to be shown."""

    display: int = 0
    """Which display is the projector, from 0."""
    window: bool = False
    """In a window of it, for a look without a projector."""
    picture: Path | None = None
    """A PNG that some other player shows full screen, instead of a display."""
    size_px: tuple[int, int] = FILE_PX
    """Of that PNG."""


def size_of(text: str) -> tuple[int, int]:
    """Read `1920x1080`. Raises `UserError`."""
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise UserError(f"'{text}' is no picture's size; give it in pixels, like 1920x1080")
    return int(width), int(height)


class _Virtual:
    """The projector in the virtual user's room."""

    changes = True

    def __init__(self, user: VirtualUser) -> None:
        self.size_px = user.projector_px
        self.show: Callable[[Picture], None] = user.project


class _File:
    """A PNG that the user shows with another player."""

    changes = False

    def __init__(self, path: Path, size_px: tuple[int, int]) -> None:
        self._path = path
        self.size_px = size_px

    def show(self, picture: Picture) -> None:
        """Write it, and wait for the user."""
        good, data = cv2.imencode(".png", picture)
        assert good  # PNG takes any picture of bytes
        try:
            with appearing(self._path) as file:
                file.write(data.tobytes())
        except OSError as error:
            raise UserError(
                f"'{self._path}' cannot be written ({error.strerror}); choose another place for it"
            ) from error
        width, height = self.size_px
        print(
            f"\nShow {self._path} full screen on the projector, {width} x {height} pixels and not "
            f"scaled, then press Enter.",
            file=sys.stderr,
        )
        if sys.stdin.isatty():  # else a program drives us, and has its own way to wait
            sys.stdin.readline()


def screen_for(source: Source, request: ScreenRequest) -> AbstractContextManager[Screen]:
    """Open what shows pictures over a source's table. Raises `UserError`."""
    if request.picture is not None:
        return nullcontext(_File(request.picture, request.size_px))
    if isinstance(source, VirtualUser):
        return nullcontext(_Virtual(source))
    return Display(request.display, full_screen=not request.window)
