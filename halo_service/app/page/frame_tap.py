"""The frames of the running service as a source, for what needs them without opening the camera
again: a recording, the wizard."""

from __future__ import annotations

import queue
from contextlib import suppress

from halo_service.geometry.camera import Camera
from halo_service.sources import EndOfSource
from halo_service.values import Frame, SourceKind


class FrameTap:
    """A `Source`. Call `put` in the live loop; a slow reader misses the oldest frames."""

    def __init__(self, kind: SourceKind, camera: Camera, waiting: int = 8) -> None:
        """`waiting`: frames that wait for the reader, up to 4 MB each."""
        self.kind = kind
        self.camera = camera
        self._frames: queue.Queue[Frame] = queue.Queue(waiting)
        self._ended = False
        self.dropped = 0
        """Frames that the reader was too slow for."""

    def put(self, frame: Frame) -> None:
        """Offer a frame; never waits."""
        if self._ended:
            return
        if self._frames.full():
            with suppress(queue.Empty):
                self._frames.get_nowait()
                self.dropped += 1
        with suppress(queue.Full):
            self._frames.put_nowait(frame)

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next frame; None: nothing came in that time. Raises `EndOfSource`."""
        try:
            return self._frames.get(timeout=timeout_s)
        except queue.Empty:
            if self._ended:
                raise EndOfSource from None
            return None

    def close(self) -> None:
        """End: what is queued can still be read."""
        self._ended = True
