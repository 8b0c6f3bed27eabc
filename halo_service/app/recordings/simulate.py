"""Render a recording of the virtual camera with its ground truth."""

from __future__ import annotations

import json
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from halo_service.app.files import STDOUT, refuse_existing, written
from halo_service.app.progress import progress
from halo_service.errors import UserError
from halo_service.outputs.recorder import Recorder


@dataclass(frozen=True, slots=True)
class SimulateRequest:
    """What the command line asks for."""

    scenario: str
    out: Path
    truth: str | None
    script: str | None
    seed: int | None
    seconds: float | None
    colour: bool


def simulate(request: SimulateRequest) -> int:
    """Render a recording at full quality, and its truth; return the number of frames.

    All files appear together when the recording is complete, or none does.
    """
    from halo_service.virtual.offline import SimulatedRecording
    from halo_service.virtual.sim_url import parse_sim_url

    simulated = parse_sim_url(_source(request.scenario), seed=request.seed)
    recording = SimulatedRecording(simulated, request.seconds, colour=request.colour)
    if STDOUT in (str(request.out), request.truth, request.script):
        raise UserError("simulate cannot write to stdout (-): name a file")
    count = 0
    with ExitStack() as stack:
        # Closed in reverse order: first the recording, which a full disk can still stop.
        script = stack.enter_context(written(request.script)) if request.script else None
        truth = stack.enter_context(written(request.truth)) if request.truth else None
        recorder = stack.enter_context(
            Recorder(request.out, recording.camera, fps=recording.camera.fps, colour=request.colour)
        )
        bar = stack.enter_context(
            progress(f"rendering {request.out.name}", recording.expected_frames)
        )
        # One frame is written while the next is drawn.
        writer = stack.enter_context(ThreadPoolExecutor(1, "write"))
        written_frame: Future[bool] | None = None
        for frame, lines in recording:
            if written_frame is not None:
                written_frame.result()
                written_frame = None
            if frame is not None:
                written_frame = writer.submit(recorder.write, frame)
                count += 1
            if truth is not None:
                truth.writelines(json.dumps(line) + "\n" for line in lines)
            bar.advance()
        if written_frame is not None:
            written_frame.result()
        if script is not None:
            script.write(json.dumps(recording.script(), indent=1) + "\n")
    return count


@dataclass(frozen=True, slots=True)
class InstallationRequest:
    """What the command line asks for of a virtual installation."""

    scenario: str
    seed: int | None
    layout: str | None
    truth: str | None
    start_s: float
    """When the truth begins; live, the scenario's time is Unix time."""
    seconds: float | None
    force: bool
    """Replace a layout file of that name: it may have changes of the user."""


def write_installation(request: InstallationRequest) -> None:
    """Write the layout and the truth of a virtual installation, each where there is a name.

    Raises `UserError` for a scenario with one camera, for a truth without a length, and for a
    layout file that exists.
    """
    from halo_service.virtual.installation.truth import canvas_truth, layout_text
    from halo_service.virtual.sim_url import parse_sim_url

    simulated = parse_sim_url(_source(request.scenario), seed=request.seed)
    if simulated.room.installation.alone:
        raise UserError(
            f"the scenario '{request.scenario}' has one camera and no canvas; "
            "try crossing,cameras=2"
        )
    if request.truth and not request.seconds:
        raise UserError("simulate: --canvas-truth needs --seconds S: the scenario never ends")
    if not request.start_s >= 0.0:
        raise UserError(f"simulate: --start is {request.start_s:g}; give 0 or a Unix time")
    if request.layout:
        refuse_existing(Path(request.layout), force=request.force)
        with written(request.layout) as file:
            file.write(layout_text(simulated))
    if request.truth and request.seconds:
        with written(request.truth) as file:
            lines = canvas_truth(simulated, request.seconds, request.start_s)
            file.writelines(json.dumps(line) + "\n" for line in lines)


def _source(scenario: str) -> str:
    return f"sim:{scenario.removeprefix('sim:')}"
