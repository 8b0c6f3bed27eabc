"""The display of the projector: one full-screen picture, in a process of its own.

Rule: only that process imports pygame, which needs the main thread on some systems and must answer
the window manager while our process is busy. When `show` returns, the picture is on the display.
"""

from __future__ import annotations

import importlib.util
import multiprocessing
import signal
from multiprocessing.connection import Connection
from typing import Self

import numpy as np
from numpy.typing import NDArray

from halo_service.errors import UserError

Picture = NDArray[np.uint8]

START_S = 20.0
"""Time for the window to open."""
TICK_S = 1.0 / 60.0
"""Time between two looks for keys and for a new picture."""


class Display:
    """A window, or a whole display: a `Screen`. Call `close()` when done, or use it in a `with`."""

    changes = True

    def __init__(self, number: int = 0, *, full_screen: bool = True) -> None:
        """Open it and wait until it is visible. Raises `UserError` if it cannot open."""
        if importlib.util.find_spec("pygame") is None:
            raise UserError(
                "a picture on the projector needs pygame-ce: run 'uv sync --extra projector'"
            )
        context = multiprocessing.get_context("spawn")
        self._pipe, far_end = context.Pipe()
        self._process = context.Process(
            target=_run, args=(far_end, number, full_screen), name="display", daemon=True
        )
        self._process.start()
        far_end.close()
        self.size_px: tuple[int, int]
        """Width and height of the picture."""
        self.desktops_px: list[tuple[int, int]]
        """The same of all displays, as programs see them."""
        self.size_px, self.desktops_px = self._opened()
        self.open = True
        """False after the user closed it with Escape, Q or its button."""

    def show(self, picture: Picture) -> None:
        """Show a (height, width, 3) BGR picture of `size_px`, until the next call.

        Does nothing after the user closed the display; see `open`.
        """
        if not self.open:
            return
        try:
            self._pipe.send_bytes(np.ascontiguousarray(picture).tobytes())
            self._pipe.recv()
        except (EOFError, OSError):
            self.open = False

    def close(self) -> None:
        """Close the display. May be called twice."""
        self.open = False
        self._pipe.close()
        self._process.join(2.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _opened(self) -> tuple[tuple[int, int], list[tuple[int, int]]]:
        answer: object = "no window in time; close other programs and try again"
        try:
            if self._pipe.poll(START_S):
                answer = self._pipe.recv()
        except EOFError:
            answer = "its process ended"
        if isinstance(answer, tuple):
            return answer
        self._pipe.close()
        self._process.kill()
        self._process.join()
        raise UserError(f"cannot open the display: {answer}")


def _run(pipe: Connection, number: int, full_screen: bool) -> None:
    """Run in the other process: show what comes through the pipe, until it ends."""
    # Before pygame: it silences the greeting of pygame.
    from halo_window import Stage, StageError

    # Ctrl-C reaches all processes of the group; our parent ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import pygame

    try:
        stage = Stage("halo", full_screen, number)
    except StageError as error:
        pipe.send(str(error))
        return
    # We measure pixels; a window that can be resized would scale them.
    width, height = stage.screen.get_size()
    pipe.send(((width, height), pygame.display.get_desktop_sizes()))
    with stage:
        while stage.open:
            try:
                if pipe.poll(TICK_S):
                    data = pipe.recv_bytes()
                    stage.screen.blit(pygame.image.frombuffer(data, (width, height), "BGR"), (0, 0))
                    stage.show()
                    pipe.send(None)
            except (EOFError, OSError):
                return
            stage.pressed()
