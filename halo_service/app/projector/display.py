"""The projector's display: one picture over the whole of it, in a process of its own.

Rule: pygame lives in that process alone, which needs its main thread on some systems and answers
the window manager while ours is busy. A picture is on its way to the glass when `show` returns.
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
"""A window that has not opened by then will not."""
TICK_S = 1.0 / 60.0
"""How often the window looks for keys and for a new picture."""


class Display:
    """A window, or a whole display: a `Screen`. Call `close()` when done, or use it in a `with`."""

    changes = True

    def __init__(self, number: int = 0, *, full_screen: bool = True) -> None:
        """Open it and wait until it is there. Raises `UserError` where it cannot be had."""
        if importlib.util.find_spec("pygame") is None:
            raise UserError(
                "a picture on the projector needs pygame-ce; `uv sync --extra projector` brings it"
            )
        context = multiprocessing.get_context("spawn")
        self._pipe, far_end = context.Pipe()
        self._process = context.Process(
            target=_run, args=(far_end, number, full_screen), name="display", daemon=True
        )
        self._process.start()
        far_end.close()
        self.size_px: tuple[int, int] = self._opened()
        """Width and height of what is shown."""
        self.open = True
        """False once the user has closed it with Escape, Q or its button."""

    def show(self, picture: Picture) -> None:
        """Show a (height, width, 3) BGR picture of `size_px`, until another comes.

        Does nothing once the user has closed the display: `open` tells.
        """
        if not self.open:
            return
        try:
            self._pipe.send_bytes(np.ascontiguousarray(picture).tobytes())
            self._pipe.recv()
        except (EOFError, OSError):
            self.open = False

    def close(self) -> None:
        """Take the picture away. May be called twice."""
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

    def _opened(self) -> tuple[int, int]:
        answer: object = "it did not open in time; try again on a less busy machine"
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
        raise UserError(f"the display cannot be had: {answer}")


def _run(pipe: Connection, number: int, full_screen: bool) -> None:
    """The other side: a window that shows what comes through the pipe, until the pipe ends."""
    from halo_window import Stage, StageError  # before pygame, whose greeting it silences

    # A whole process group is told to stop; ending this one is its parent's affair.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import pygame

    try:
        stage = Stage("halo", full_screen, number)
    except StageError as error:
        pipe.send(str(error))
        return
    # What is measured is pixels: a window that could be resized would scale them.
    width, height = stage.screen.get_size()
    pipe.send((width, height))
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
