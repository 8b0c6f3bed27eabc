"""Record any source into a file."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import FrameType

from halo_service.app.progress import progress
from halo_service.app.sources import open_source
from halo_service.outputs.recorder import Recorder
from halo_service.settings import SourceSettings
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame

log = logging.getLogger(__name__)

READ_S = 0.25
"""Longest wait for a frame, so that Ctrl-C works soon."""


def record(out: Path, settings: SourceSettings, seconds: float | None, colour: bool) -> int:
    """Record a source until it ends, `seconds` are over or Ctrl-C; return the number of frames.

    Raises `UserError` if the source or the file fails; then no file is left.
    """
    # A recording is copied as fast as possible, with every frame.
    source, _ = open_source(replace(settings, fast=settings.name.startswith("recording:")))
    stopped = threading.Event()

    def stop(number: int, where: FrameType | None) -> None:
        stopped.set()

    with ExitStack() as stack:
        stack.callback(source.close)
        for number in (signal.SIGINT, signal.SIGTERM):
            stack.callback(signal.signal, number, signal.signal(number, stop))
        recorder = stack.enter_context(
            Recorder(out, source.camera, fps=source.camera.fps, colour=colour)
        )
        bar = stack.enter_context(progress(f"recording {out.name}"))
        count, first_us = 0, None
        for frame in _captures(source, stopped):
            first_us = frame.time_us if first_us is None else first_us
            if seconds is not None and frame.time_us - first_us >= 1e6 * seconds:
                break
            # A player would show Unix time as a length of decades, so a live recording begins at 0.
            start_us = 0 if source.kind == "recording" else first_us
            count += recorder.write(replace(frame, time_us=frame.time_us - start_us))
            bar.advance()
    return count


def _captures(source: Source, stopped: threading.Event) -> Iterator[Frame]:
    """Yield good frames until the source ends or the user stops."""
    while not stopped.is_set():
        try:
            capture = source.read(READ_S)
        except EndOfSource:
            return
        if isinstance(capture, BadFrame):
            log.warning("bad frame, not recorded: %s", capture.reason)
        elif capture is not None:
            yield capture
