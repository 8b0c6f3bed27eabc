"""A camera, and a recording that is shown in its place for a while.

Rule: whoever reads notices nothing: both have the same lenses. The reader's thread changes between
them, so a source is never closed while it is read.
"""

from __future__ import annotations

import logging
from collections import deque

from halo_service.errors import SourceLost, UserError
from halo_service.geometry.camera import Camera
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame, SourceKind

log = logging.getLogger(__name__)

MOST_OLD = 60
"""Captures that wait in a camera that was not read; they are of the past."""


class SwitchedSource:
    """A `Source`."""

    def __init__(self, source: Source) -> None:
        self.source = source
        """The camera, or what the service was started with."""
        self.shown: Source | None = None
        """What is read in its place."""
        self._wanted: deque[Source | None] = deque()

    @property
    def kind(self) -> SourceKind:
        """Where the frames come from now."""
        shown = self.shown
        return shown.kind if shown is not None else self.source.kind

    @property
    def camera(self) -> Camera:
        """The lenses."""
        return self.source.camera

    def show(self, source: Source | None) -> None:
        """Read a source with the same lenses from now on, until it ends; None: the camera again.

        From any thread. The source is closed here.
        """
        self._wanted.append(source)

    def reopened(self, source: Source) -> SwitchedSource:
        """Use a camera that was lost and is found again."""
        self.source = source
        return self

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Return the next capture of what is shown."""
        while self._wanted:
            self._change(self._wanted.popleft())
        if self.shown is None:
            return self.source.read(timeout_s)
        try:
            return self.shown.read(timeout_s)
        except EndOfSource:
            log.info("source: the recording has ended; the camera is used again")
        except UserError as error:
            log.warning("source: %s; the camera is used again", error)
        self._change(None)
        return None

    def close(self) -> None:
        """Close both. May be called twice."""
        while self._wanted:
            self._change(self._wanted.popleft())
        if self.shown is not None:
            self.shown.close()
            self.shown = None
        self.source.close()

    def _change(self, to: Source | None) -> None:
        before, self.shown = self.shown, to
        if before is not None:
            before.close()
        if to is None:
            self._drop_old()

    def _drop_old(self) -> None:
        """Drop what the camera captured meanwhile."""
        try:
            for _ in range(MOST_OLD):
                if self.source.read(0.0) is None:
                    return
        except (SourceLost, EndOfSource):
            return  # the next read raises it again, where it is handled
