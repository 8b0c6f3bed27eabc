"""Frames as a device hands them over, held in memory and played at their own pace."""

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
"""Of colour that was drawn; the Kinect's own JPEG is about as large."""
LEAD_NS = 50_000_000
"""From the first time somebody asks to the first frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Handed:
    """One capture before anything is decoded."""

    time_us: int
    depth: bytes
    """uint16, mm, row by row in this machine's byte order."""
    ir: bytes
    """Likewise."""
    jpeg: bytes | None
    """The colour as the camera sends it, or None."""


def handed(frame: Frame) -> Handed:
    """Turn a frame back into what a device would have handed over."""
    return Handed(frame.time_us, frame.depth.tobytes(), frame.ir.tobytes(), _jpeg(frame.colour))


def unpacked(each: Handed, camera: Camera) -> Frame:
    """Make a frame of it; depth and IR are views of its bytes, the JPEG stays one."""
    shape = (camera.depth.height, camera.depth.width)
    depth = np.frombuffer(each.depth, np.uint16).reshape(shape)
    ir = np.frombuffer(each.ir, np.uint16).reshape(shape)
    return Frame(each.time_us, depth, ir, each.jpeg)


class Player:
    """A `Source` that hands out a take once, at the take's own pace.

    A reader that is late gets the newest frame, as from a camera: what it missed is counted in
    `dropped`, and how long the frame has waited for it is the frame's first stage.
    """

    def __init__(
        self, take: Sequence[Handed], camera: Camera, kind: SourceKind, watch: Stopwatch
    ) -> None:
        """`take`: at least one capture, by time."""
        self.camera = camera
        self.kind = kind
        self.dropped = 0
        self._take = take
        self._watch = watch
        self._next = 0
        self._began_ns: int | None = None

    def read(self, timeout_s: float) -> Frame | None:
        """Give the next capture once it is due, or the newest that is."""
        now_ns = time.perf_counter_ns()
        if self._began_ns is None:
            self._began_ns = now_ns + LEAD_NS
        if self._next == len(self._take):
            raise EndOfSource
        while self._next + 1 < len(self._take) and self._due_ns(self._next + 1) <= now_ns:
            self._next += 1
            self.dropped += 1
        due_ns = self._due_ns(self._next)
        wait_s = (due_ns - now_ns) / 1e9
        time.sleep(max(0.0, min(wait_s, timeout_s)))
        if wait_s > timeout_s:
            return None
        each = self._take[self._next]
        self._next += 1
        self._watch.begin(each.time_us, due_ns)
        self._watch.lap("wait")
        frame = unpacked(each, self.camera)
        self._watch.lap("unpack")
        return frame

    def close(self) -> None:
        """There is nothing to let go."""

    def _due_ns(self, number: int) -> int:
        assert self._began_ns is not None  # `read` begins
        return self._began_ns + 1000 * (self._take[number].time_us - self._take[0].time_us)


def _jpeg(colour: NDArray[np.uint8] | bytes | None) -> bytes | None:
    if colour is None or isinstance(colour, bytes):
        return colour
    done, data = cv2.imencode(".jpg", colour, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    assert done  # 8 bits of three colours always can
    return data.tobytes()
