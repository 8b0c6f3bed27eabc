"""A recording as a source, like a camera: no SDK needed.

Rule: this module decides when a frame is due and its time; `matroska` reads the file.

Time. As fast as possible (`realtime=False`): the depth packets' own timestamps, no offset
removed or added, so that the same file gives the same numbers. At its own pace (`realtime`):
the first frame is due at the first read, and frames carry the Unix time at which
they are due, like a camera's. In a loop the next round starts one frame period after the last
frame, so time always rises.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera
from halo_service.host_clock import CLOCK
from halo_service.sources import EndOfSource
from halo_service.sources.matroska import KinectFile, no_frames
from halo_service.values import BadFrame, Frame, SourceKind

_US_PER_S = 1_000_000
_OPENING_CAPTURES = 300
"""The first good frame must be within these, 10 s: a camera may start with colour alone."""
_LATE_US = 300_000
"""A frame that is due for longer is not caught up with: on a machine that is too slow to read it,
the recording runs slower, and its time passes slower by the same amount. So time never leaps."""


class Recording:
    """A `Source` that reads a recording of an Azure Kinect, or one of ours."""

    kind: SourceKind = "recording"

    def __init__(self, path: Path, *, realtime: bool, loop: bool) -> None:
        """Open, check, and read to the first good frame; raises UserError with the remedy."""
        self._path = path
        self._loop = loop
        self._pace = Pace() if realtime else None
        self._file = KinectFile(path)
        self.camera: Camera = self._file.camera
        self._outcomes = self._from_first_frame()
        self._ahead: Frame | BadFrame | None = None
        """Read and decoded, but not yet due."""

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Return the next capture when it is due; raises UserError where the file is cut off."""
        if self._ahead is None:
            self._ahead = next(self._outcomes, None)
        if self._ahead is None:
            raise EndOfSource
        capture = self._ahead
        if self._pace is not None:
            unix_us = self._pace.due_us(capture.time_us)
            if not self._pace.wait_until(unix_us, timeout_s):
                return None
            capture = replace(capture, time_us=unix_us)
        self._ahead = None
        return capture

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._file.close()

    def _from_first_frame(self) -> Iterator[Frame | BadFrame]:
        outcomes = self._rounds()
        opening: list[Frame | BadFrame] = []
        try:
            for outcome in islice(outcomes, _OPENING_CAPTURES):
                opening.append(outcome)
                if isinstance(outcome, Frame):
                    return chain(opening, outcomes)
            raise no_frames(self._path)
        except UserError:
            self.close()
            raise

    def _rounds(self) -> Iterator[Frame | BadFrame]:
        """Yield every capture, round after round, with times that continue the file's."""
        shift_us = 0
        while True:
            times: list[int] = []
            frames = 0
            for capture in self._file.captures():
                outcome = self._file.decode(capture)
                frames += isinstance(outcome, Frame)
                times.append(outcome.time_us)
                yield replace(outcome, time_us=outcome.time_us + shift_us)
            self._check_end(frames)
            if not self._loop:
                return
            shift_us += max(times) - min(times) + round(_US_PER_S / self.camera.fps)
            self._file.close()
            self._file = KinectFile(self._path)

    def _check_end(self, frames: int) -> None:
        if frames == 0:
            raise no_frames(self._path)
        if not self._file.closed_by_writer:
            raise UserError(
                f"{self._path} was never closed, and ends after {frames} frames: it is still being "
                "recorded, or its program was killed; wait for its end, or record it again."
            )
        if not self._file.whole:
            raise UserError(
                f"{self._path} is cut off after {frames} frames: it is damaged; copy or record it "
                "again."
            )


class Pace:
    """When a frame of the file is due, in Unix time; the first is due at once."""

    def __init__(self, unix_us: Callable[[], int] = CLOCK.unix_us) -> None:
        self._now_us = unix_us
        self._unix_minus_file_us: int | None = None

    def due_us(self, file_us: int) -> int:
        """Return when the frame with this time in the file is due."""
        now_us = self._now_us()
        if self._unix_minus_file_us is None:
            self._unix_minus_file_us = now_us - file_us
        late_us = now_us - (file_us + self._unix_minus_file_us)
        if late_us > _LATE_US:
            self._unix_minus_file_us += late_us - _LATE_US
        return file_us + self._unix_minus_file_us

    def wait_until(self, unix_us: int, timeout_s: float) -> bool:
        """Wait for a time, at most `timeout_s`; return whether it has come."""
        wait_s = (unix_us - self._now_us()) / _US_PER_S
        time.sleep(max(0.0, min(wait_s, timeout_s)))
        return wait_s <= timeout_s
