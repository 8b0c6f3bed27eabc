"""Record any source into a file: every frame, or a word about those that were lost."""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from typing import Protocol

from halo_service.app.files import refuse_existing
from halo_service.app.process import endings
from halo_service.app.progress import progress
from halo_service.app.recordings.area import AreaCut
from halo_service.app.sources import open_source
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import require_fit
from halo_service.runtime.checks import check_capture
from halo_service.settings import SourceSettings
from halo_service.sources import EndOfSource, Source, SourceLost
from halo_service.values import BadFrame, Frame

log = logging.getLogger(__name__)

READ_S = 0.25
"""Longest wait for a frame, so that Ctrl-C works soon."""
SILENCE_S = 60.0
"""A camera without a frame for so long gives no more."""
WAITING = 60
"""Frames that wait to be written, up to 4 MB each: encoding must not delay reading, for a camera
drops what is not read in time."""
TOLERATED = 0.05
"""Share of frames that may be lost; a good USB port loses less than 1 %."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """What is in the file, and what is not."""

    frames: int = 0
    lost: int = 0
    """Frames that the camera captured and that never came."""
    bad: int = 0
    """Captures without depth or infrared."""
    ended: str = ""
    """Why it ended early; empty: as planned."""

    @property
    def complete(self) -> bool:
        """Whether it is worth calling a recording."""
        missing = self.lost + self.bad
        return not self.ended and missing <= TOLERATED * (self.frames + missing)


class Writer(Protocol):
    """What writes the frames."""

    def write(self, frame: Frame) -> bool:
        """Append a frame; False: it was not written."""


def _everything(frame: Frame) -> Frame:
    return frame


def record(
    out: Path,
    settings: SourceSettings,
    seconds: float | None,
    colour: bool,
    force: bool = False,
    area: Profile | None = None,
) -> Recorded:
    """Record a source until it ends, `seconds` are over or Ctrl-C.

    `area`: record only the surface of this profile and what is near it, without colour. Raises
    `UserError` if there is such a file and not `force`, or if source or file fails before the first
    frame; then no file is left. What was recorded until a camera is lost is stored.
    """
    refuse_existing(out, force=force)
    # A recording is copied as fast as possible, with every frame.
    fast = settings.name.startswith("recording:")
    source, _ = open_source(replace(settings, fast=fast), area.camera.serial if area else "")
    stopped = threading.Event()

    def stop(number: int, where: FrameType | None) -> None:
        stopped.set()

    with ExitStack() as stack:
        stack.callback(source.close)
        for number in endings():
            stack.callback(signal.signal, number, signal.signal(number, stop))
        cut = _everything
        if area is not None:
            require_fit(area, source.camera)
            cut, colour = AreaCut(area).cut, False
        recorder = stack.enter_context(
            Recorder(out, source.camera, fps=source.camera.fps, colour=colour)
        )
        bar = stack.enter_context(progress(f"recording {out.name}"))
        return copy_frames(source, recorder, seconds, stopped, bar.advance, cut)


def copy_frames(
    source: Source,
    writer: Writer,
    seconds: float | None,
    stopped: threading.Event,
    advance: Callable[[], None] = lambda: None,
    cut: Callable[[Frame], Frame] = _everything,
) -> Recorded:
    """Read and write in two threads; return what came. `cut`: what of a frame is written."""
    frames, lost, bad, ended = 0, 0, 0, ""
    first_us = last_us = None
    live = source.kind != "recording"
    with ThreadPoolExecutor(1, "recorder") as thread:
        written: deque[Future[bool]] = deque()
        try:
            for capture in _captures(source, stopped):
                first_us = capture.time_us if first_us is None else first_us
                if seconds is not None and capture.time_us - first_us >= 1e6 * seconds:
                    break
                lost += check_capture(capture, last_us, source.camera.fps).missed if live else 0
                last_us = capture.time_us
                if isinstance(capture, BadFrame):
                    bad += 1
                    continue
                # A player would show Unix time as decades, so a live recording begins at 0.
                frame = replace(capture, time_us=capture.time_us - first_us) if live else capture
                written.append(thread.submit(lambda each: writer.write(cut(each)), frame))
                if len(written) > WAITING:
                    frames += written.popleft().result()
                advance()
        except SourceLost as error:
            if first_us is None:
                raise
            ended = str(error)
        frames += sum(each.result() for each in written)
    return Recorded(frames, lost, bad, ended)


def _captures(source: Source, stopped: threading.Event) -> Iterator[Frame | BadFrame]:
    """Yield captures until the source ends or the user stops. Raises `SourceLost`."""
    received_s = time.monotonic()
    while not stopped.is_set():
        try:
            capture = source.read(READ_S)
        except EndOfSource:
            return
        if capture is not None:
            received_s = time.monotonic()
            yield capture
        elif time.monotonic() - received_s > SILENCE_S:
            raise SourceLost(f"camera: no frame for {SILENCE_S:.0f} s; check its cable")
