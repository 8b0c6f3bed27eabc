"""Frames for the steps, out of any source. Time is the frames' own: no clock here."""

from __future__ import annotations

from collections.abc import Iterator

from halo_calibration.errors import CalibrationError
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame

READ_S = 1.0
PATIENCE = 10
"""Reads without a frame, of a second each, until the source is given up."""
US_PER_S = 1_000_000


class Session:
    """Reads a source in pieces."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._first_us: int | None = None
        self._ahead: Frame | BadFrame | None = None
        """Read, but belongs to the next piece."""

    def frame_count(self, seconds: float) -> int:
        """Return how many frames the camera gives in a time."""
        return round(seconds * self._source.camera.fps)

    def lasting(self, seconds: float, during: str) -> Iterator[Frame]:
        """Yield the good frames of the next `seconds`, from the next frame on."""
        until_us: int | None = None
        while True:
            capture = self._read(during)
            if until_us is None:
                until_us = capture.time_us + round(seconds * US_PER_S)
            if capture.time_us >= until_us:
                return
            if isinstance(capture, Frame):
                yield capture

    def between(self, from_s: float, to_s: float, during: str) -> Iterator[Frame]:
        """Yield the good frames of a window, in seconds since the source's first frame."""
        while True:
            try:
                capture = self._read(during)
            except _EndedError:
                return
            assert self._first_us is not None  # the first read sets it
            seconds = (capture.time_us - self._first_us) / US_PER_S
            if seconds >= to_s:
                self._ahead = capture
                return
            if seconds >= from_s and isinstance(capture, Frame):
                yield capture

    def _read(self, during: str) -> Frame | BadFrame:
        ahead, self._ahead = self._ahead, None
        if ahead is not None:
            return ahead
        for _ in range(PATIENCE):
            try:
                capture = self._source.read(READ_S)
            except EndOfSource:
                raise _EndedError(
                    f"the recording ended during '{during}': record all of it, or correct the "
                    f"script's times"
                ) from None
            if capture is not None:
                if self._first_us is None:
                    self._first_us = capture.time_us
                return capture
        raise CalibrationError(
            f"no frame came for {PATIENCE * READ_S:.0f} s during '{during}': check the camera's "
            f"cable, and start again"
        )


class _EndedError(CalibrationError):
    pass
