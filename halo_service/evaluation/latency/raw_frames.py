"""Frames as a device delivers them, held in memory and replayed at their own pace."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.latency.stopwatch import Stopwatch
from halo_service.geometry.camera import Camera
from halo_service.sources import EndOfSource
from halo_service.values import Frame, SourceKind

JPEG_QUALITY = 90
"""Of simulated colour; the Kinect's own JPEG is about as large."""
LEAD_NS = 50_000_000
"""From the first `read` to the first frame."""


@dataclass(frozen=True, slots=True, eq=False)
class RawFrame:
    """One capture before anything is decoded."""

    time_us: int
    depth: bytes
    """uint16, mm, row by row in this machine's byte order."""
    ir: bytes
    """Likewise."""
    jpeg: bytes | None
    """The colour as the camera sends it, or None."""


def to_raw(frame: Frame) -> RawFrame:
    """Turn a frame back into what a device would have delivered."""
    return RawFrame(frame.time_us, frame.depth.tobytes(), frame.ir.tobytes(), _jpeg(frame.colour))


def unpack(each: RawFrame, camera: Camera) -> Frame:
    """Return the frame; depth and IR are views of the bytes, the JPEG stays a JPEG."""
    shape = (camera.depth.height, camera.depth.width)
    depth = np.frombuffer(each.depth, np.uint16).reshape(shape)
    ir = np.frombuffer(each.ir, np.uint16).reshape(shape)
    return Frame(each.time_us, depth, ir, each.jpeg)


class PacedSource:
    """A `Source` that replays frames once, at their own pace.

    A late reader gets the newest frame, as from a camera: missed ones are counted in `dropped`,
    and the frame's wait for the reader is its first stage.
    """

    def __init__(
        self, frames: Sequence[RawFrame], camera: Camera, kind: SourceKind, watch: Stopwatch
    ) -> None:
        """`frames`: at least one, by time."""
        self.camera = camera
        self.kind = kind
        self.dropped = 0
        self._frames = frames
        self._watch = watch
        self._next = 0
        self._began_ns: int | None = None

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next capture once it is due, or the newest that is."""
        now_ns = time.perf_counter_ns()
        if self._began_ns is None:
            self._began_ns = now_ns + LEAD_NS
        if self._next == len(self._frames):
            raise EndOfSource
        while self._next + 1 < len(self._frames) and self._due_ns(self._next + 1) <= now_ns:
            self._next += 1
            self.dropped += 1
        due_ns = self._due_ns(self._next)
        wait_s = (due_ns - now_ns) / 1e9
        time.sleep(max(0.0, min(wait_s, timeout_s)))
        if wait_s > timeout_s:
            return None
        each = self._frames[self._next]
        self._next += 1
        self._watch.begin(each.time_us, due_ns)
        self._watch.lap("wait")
        frame = unpack(each, self.camera)
        self._watch.lap("unpack")
        return frame

    def close(self) -> None:
        """Nothing to release."""

    def _due_ns(self, number: int) -> int:
        assert self._began_ns is not None  # `read` begins
        return self._began_ns + 1000 * (self._frames[number].time_us - self._frames[0].time_us)


def _jpeg(colour: NDArray[np.uint8] | bytes | None) -> bytes | None:
    if colour is None or isinstance(colour, bytes):
        return colour
    done, data = cv2.imencode(".jpg", colour, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    assert done  # 8 bits of three colours always can
    return data.tobytes()
