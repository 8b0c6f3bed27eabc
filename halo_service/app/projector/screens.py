"""Opens what shows pictures on the table: a display, the virtual projector, or a file.

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
from halo_service.app.projector.scaling import doubt_about
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.sources import Source

Picture = NDArray[np.uint8]

FILE_PX = (1920, 1080)
"""Default size of the picture in a file: that of most projectors."""


@dataclass(frozen=True, slots=True)
class ScreenRequest:
    """Where to show pictures."""

    display: int = 0
    """Number of the projector's display, from 0."""
    window: bool = False
    """In a window of that display, to try it without a projector."""
    picture: Path | None = None
    """A PNG to write for another program that shows it full screen."""
    size_px: tuple[int, int] | None = None
    """Width and height of that PNG, or of the projector, where the user states it."""


def size_of(text: str) -> tuple[int, int]:
    """Read `1920x1080`. Raises `UserError`."""
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise UserError(f"'{text}' is not a picture size; write it in pixels, like 1920x1080")
    return int(width), int(height)


class _Virtual:
    """The virtual projector."""

    changes = True

    def __init__(self, user: VirtualUser) -> None:
        self.size_px = user.projector_px
        self.show: Callable[[Picture], None] = user.project


class _File:
    """A PNG that the user shows with another program."""

    changes = False

    def __init__(self, path: Path, size_px: tuple[int, int]) -> None:
        self._path = path
        self.size_px = size_px

    def show(self, picture: Picture) -> None:
        """Write it, and wait for the user."""
        good, data = cv2.imencode(".png", picture)
        assert good  # PNG can hold any picture of bytes
        try:
            with appearing(self._path) as file:
                file.write(data.tobytes())
        except OSError as error:
            raise UserError(
                f"'{self._path}' cannot be written ({error.strerror}); choose another path"
            ) from error
        width, height = self.size_px
        print(
            f"\nShow {self._path} full screen on the projector, {width} x {height} pixels and not "
            f"scaled, then press Enter.",
            file=sys.stderr,
        )
        if sys.stdin.isatty():  # otherwise a program runs us, and waits by its own means
            sys.stdin.readline()


def screen_for(source: Source, request: ScreenRequest) -> AbstractContextManager[Screen]:
    """Open the screen for the table of a source. Raises `UserError`."""
    if request.picture is not None:
        return nullcontext(_File(request.picture, request.size_px or FILE_PX))
    if isinstance(source, VirtualUser):
        return nullcontext(_Virtual(source))
    display = Display(request.display, full_screen=not request.window)
    doubt = _doubt(display, request)
    if doubt:
        display.close()
        raise UserError(f"display {request.display}: {doubt}")
    return display


def _doubt(display: Display, request: ScreenRequest) -> str:
    """Return why the picture's pixels may not be the projector's; empty if they are."""
    if request.window:
        return ""  # to try it, without a projector
    if request.size_px is None:
        return doubt_about(display.size_px, display.desktops_px)
    return "" if request.size_px == display.size_px else _scaled(display.size_px, request.size_px)


def _scaled(size_px: tuple[int, int], stated_px: tuple[int, int]) -> str:
    shown, stated = ("{} x {}".format(*each) for each in (size_px, stated_px))
    return (
        f"programs see {shown} pixels there, and the projector has {stated}: its desktop "
        f"is scaled, and other programs would draw beside your fingers; set the scale of that "
        f"display to 100 % and its resolution to {stated}"
    )
