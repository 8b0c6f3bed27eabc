"""The virtual camera as a live source, in a process of its own.

Rule: this side only waits and copies. Frames come through a small ring in shared memory, the
newest wins, and whoever is slow misses some, as with a real device. The other side is in
`worker`; it ends when this process does, however that happens.
"""

from __future__ import annotations

import atexit
import math
import multiprocessing
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.shared_memory import SharedMemory
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from halo_service.errors import SourceLost, UserError
from halo_service.geometry.surface import Surface
from halo_service.values import BadFrame, Frame, SourceKind
from halo_service.virtual import worker
from halo_service.virtual.ring import Ring, ring_bytes
from halo_service.virtual.sim_url import SimRequest

START_S = 60.0
"""A worker that has not shown a frame so long after the first read has hung. Usual is under 2 s,
but several services that start at once on two cores need half a minute."""


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Ctrl-C reaches the whole process group; the parent ends the worker."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may say what signals do
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


class VirtualKinect:
    """A camera that is not there. Call `close()` when done, or use it in a `with`."""

    kind: Final[SourceKind] = "virtual"

    def __init__(
        self, request: SimRequest, *, colour: bool = True, truth_path: str | None = None
    ) -> None:
        """Start the worker; the first frame follows within about two seconds.

        `truth_path` writes the truth, one JSON line a frame and a touch.
        """
        self.camera = request.room.camera()
        self.surface: Surface = request.room.surface()
        self.room = request.room
        self._memory = SharedMemory(create=True, size=ring_bytes(self.camera.depth))
        self._ring = Ring(self._memory, self.camera.depth)
        context = multiprocessing.get_context("spawn")
        self._pipe, far_end = context.Pipe()
        self._process = context.Process(
            target=worker.run,
            args=(far_end, self._memory.name, request, colour, truth_path),
            name="virtual-kinect",
            daemon=True,
        )
        with _deaf_to_ctrl_c():  # the child inherits it, before its first line
            self._process.start()
        far_end.close()
        # The worker is deaf to signals: without this, forgetting `close()` would hang the exit.
        atexit.register(self.close)
        self._seen = 0
        self._colour = True
        self._deadline = math.inf
        """Of the first frame: nothing is drawn before the first read."""

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """The newest frame not read yet, waiting for one; None when none came in time.

        Raises SourceLost when the worker has died or does not start.
        """
        if self._seen == 0:
            self._deadline = min(self._deadline, time.monotonic() + START_S)
        frame = self._ring.newest(after=self._seen)
        if frame is None:
            self._ask(timeout_s)
            frame = self._ring.newest(after=self._seen)
        if frame is None:
            if self._seen == 0 and time.monotonic() > self._deadline:
                raise SourceLost(
                    "The virtual camera does not start; try again on a less busy machine."
                )
            return None
        self._seen, picture = frame
        return picture

    def command(self, message: Any) -> None:
        """Hand a message to the scenario (the `hand` scenario listens)."""
        try:
            self._pipe.send(("command", message))
        except OSError:
            raise self._died() from None

    def show(self, picture: NDArray[np.uint8] | None) -> None:
        """Let the projector show a picture from now on, (h, w, 3) BGR of its size; None: off."""
        try:
            self._pipe.send(("show", picture))
        except OSError:
            raise self._died() from None

    def with_colour(self, wanted: bool) -> None:
        """Draw colour or leave it out from the next frames on; without it frames cost less."""
        if wanted == self._colour:
            return
        self._colour = wanted
        try:
            self._pipe.send(("colour", wanted))
        except OSError:
            raise self._died() from None

    def close(self) -> None:
        """End the worker and give the memory back. May be called twice."""
        if self._pipe.closed:
            return
        atexit.unregister(self.close)
        self._pipe.close()
        self._process.join(2.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._ring.release()
        self._memory.close()
        self._memory.unlink()

    def __enter__(self) -> VirtualKinect:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, timeout_s: float) -> None:
        """Wait until the worker says that there is a newer frame than the last one read."""
        try:
            self._pipe.send(("next", self._seen))
            end = time.monotonic() + timeout_s
            while self._pipe.poll(max(0.0, end - time.monotonic())):
                answer, number = self._pipe.recv()
                if answer == "failed":
                    raise UserError(number)
                if number > self._seen:
                    return
        except (EOFError, OSError):
            raise self._died() from None

    def _died(self) -> SourceLost:
        self._process.join(1.0)
        return SourceLost(
            f"The virtual camera's process ended unexpectedly (code {self._process.exitcode}); "
            "start it again."
        )
