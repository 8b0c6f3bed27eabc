"""`halo simulate` and `halo record`: takes of the virtual Kinect, or of any source."""

from __future__ import annotations

import json
import logging
import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType

from tqdm import tqdm

from halo_service.app.files import STDOUT, written
from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.outputs.recorder import Recorder
from halo_service.settings import SourceSettings
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame

log = logging.getLogger(__name__)

READ_S = 0.25
"""Longest wait for a capture, so that Ctrl-C is heard."""


@dataclass(frozen=True, slots=True)
class Simulated:
    """What `halo simulate` is asked for."""

    scenario: str
    out: Path
    truth: str | None
    script: str | None
    seed: int | None
    seconds: float | None
    colour: bool


def simulate(asked: Simulated) -> int:
    """Draw a take at full quality with its truth beside it; return the number of frames.

    All of its files appear together when it is complete, or none does.
    """
    from halo_service.virtual.offline import Take
    from halo_service.virtual.sim_url import parse_sim_url

    request = parse_sim_url(f"sim:{asked.scenario.removeprefix('sim:')}", seed=asked.seed)
    take = Take(request, asked.seconds, colour=asked.colour)
    if STDOUT in (str(asked.out), asked.truth, asked.script):
        raise UserError("simulate writes files; name them, '-' is none")
    count = 0
    with ExitStack() as stack:
        # Left in reverse order: the recording, which can still fail on a full disk, comes first.
        script = stack.enter_context(written(asked.script)) if asked.script else None
        truth = stack.enter_context(written(asked.truth)) if asked.truth else None
        recorder = stack.enter_context(
            Recorder(asked.out, take.camera, fps=take.camera.fps, colour=asked.colour)
        )
        bar = stack.enter_context(tqdm(total=take.expected_frames, unit=" frames", leave=False))
        for frame, lines in take:
            if frame is not None:
                recorder.write(frame)
                count += 1
            if truth is not None:
                truth.writelines(json.dumps(line) + "\n" for line in lines)
            bar.update()
        if script is not None:
            script.write(json.dumps(take.script(), indent=1) + "\n")
    return count


def record(out: Path, settings: SourceSettings, seconds: float | None, colour: bool) -> int:
    """Record a source until it ends, `seconds` are over or Ctrl-C; return the number of frames.

    Raises `UserError` where the source or the file fails; what was recorded is then not kept.
    """
    # A recording is copied as fast as it goes, and nothing of it is left out.
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
        bar = stack.enter_context(tqdm(unit=" frames", leave=False))
        count, first_us = 0, None
        for frame in _captures(source, stopped):
            first_us = frame.time_us if first_us is None else first_us
            if seconds is not None and frame.time_us - first_us >= 1e6 * seconds:
                break
            # A player would show Unix time as a length of decades, so a live take begins at 0.
            start_us = 0 if source.kind == "recording" else first_us
            count += recorder.write(replace(frame, time_us=frame.time_us - start_us))
            bar.update()
    return count


def _captures(source: Source, stopped: threading.Event) -> Iterator[Frame]:
    """Yield what can be recorded until the source ends or somebody stops it."""
    while not stopped.is_set():
        try:
            capture = source.read(READ_S)
        except EndOfSource:
            return
        if isinstance(capture, BadFrame):
            log.warning("frame: %s; it is not in the recording", capture.reason)
        elif capture is not None:
            yield capture
