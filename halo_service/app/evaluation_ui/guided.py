"""`halo evaluate --live DIR`: a guided session on a real table, recorded.

The user touches each cross of the printed sheet, rests the finger on pegs and presses on a scale.
The crosses are around the middle of the profile's surface, so that surface must be calibrated with
the sheet. The session writes a recording and a script of the prompts; any later version can
evaluate both again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from halo_calibration.base_model import is_device
from halo_calibration.boards.sheets import CROSSES_MM, cross_name
from halo_calibration.steps.session import Session
from halo_service.app.files import written
from halo_service.app.progress import progress
from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.geometry.surface import Surface
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, require_fit, require_touch
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.values import Frame
from halo_service.virtual.camera import SERIAL
from halo_service.virtual.scenarios.study import FORCES_G, HEIGHTS_MM

RECORDING, SCRIPT = "first-light.mkv", "first-light.json"
"""The files that the session writes."""
TOUCH_S, LEVEL_S = 2.5, 3.0
"""Chosen: enough time to read a prompt and touch a cross, and to read a scale."""
READY_S = 5.0
"""Chosen: enough time to place a peg, or for the scale to settle."""
ROUNDS = 2
"""Crosses: relaxed, then fast. Levels: twice each, as in the paper (5.2.2)."""
MARGIN_MM = 10.0
"""Surface around the outer crosses: people miss them by a few mm (chosen)."""

Line = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Prompt:
    """One thing that the user does."""

    words: str
    ready_s: float
    """Time to get ready; frames in it do not count."""
    seconds: float
    step: str
    fields: dict[str, Any]
    """More fields of its line in the script."""


def session_prompts(surface: Surface) -> Iterator[Prompt]:
    """Yield the whole session: 32 touches, 10 heights, 10 forces; four minutes.

    The crosses lie around the surface's middle.
    """
    for how in ("once", "once, as short as you can"):
        for number, (x, y) in enumerate(CROSSES_MM):
            words = f"Touch cross {cross_name(number)} {how}."
            place = [surface.width_mm / 2.0 + x, surface.height_mm / 2.0 + y]
            yield Prompt(words, 0.0, TOUCH_S, "target", {"target_mm": place})
    for _ in range(ROUNDS):
        for height_mm in HEIGHTS_MM:
            words = f"Rest the fingertip on the peg of {height_mm:g} mm, so that it hides the peg."
            yield Prompt(words, READY_S, LEVEL_S, "hover", {"height_mm": height_mm})
        for force_g in FORCES_G:
            words = f"Press until the scale shows {force_g:.0f} g, and hold."
            yield Prompt(words, READY_S, LEVEL_S, "pressure", {"force_g": force_g})


def run_session(settings: Settings, folder: Path, colour: bool = True) -> tuple[Path, Path]:
    """Run the session; return the paths of the recording and of its script.

    Raises `UserError` if the profile does not fit or lacks something, or the folder cannot be
    written; then no file is left.
    """
    profile = _profile(settings)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"cannot create the folder {folder} ({error.strerror}); choose another: --live DIR"
        ) from error
    recording, script = folder / RECORDING, folder / SCRIPT
    with ExitStack() as stack:
        source, _ = open_source(settings.source, profile.camera.serial)
        stack.callback(source.close)
        require_fit(profile, source.camera)
        file = stack.enter_context(written(str(script)))
        fps = source.camera.fps
        recorder = stack.enter_context(Recorder(recording, source.camera, fps=fps, colour=colour))
        bar = stack.enter_context(progress(f"recording {recording.name}"))

        def keep(frame: Frame) -> None:
            recorder.write(frame)
            bar.advance()

        lines = conduct(tuple(session_prompts(profile.surface)), source, bar.say, keep)
        file.write(json.dumps(lines, indent=1) + "\n")
    return recording, script


def conduct(
    prompts: Sequence[Prompt],
    source: Source,
    say: Callable[[str], None],
    keep: Callable[[Frame], None],
) -> list[Line]:
    """Say one prompt after another and pass each frame to `keep`; return the script.

    Times start at the first frame, which gets time 0. The frame between two prompts belongs to
    neither and is left out.
    """
    session = Session(source)
    first_us: int | None = None
    lines: list[Line] = []
    for prompt in prompts:
        say(prompt.words)
        times: list[float] = []
        for frame in session.lasting(prompt.ready_s + prompt.seconds, prompt.step):
            first_us = frame.time_us if first_us is None else first_us
            keep(replace(frame, time_us=frame.time_us - first_us))
            times.append((frame.time_us - first_us) / 1e6)
        if times:
            from_s = times[0] + prompt.ready_s
            lines.append(
                {"step": prompt.step, "from_s": from_s, "to_s": times[-1], **prompt.fields}
            )
    return lines


def require_crosses(profile: Profile) -> None:
    """Raise `UserError` for a profile in which the positions of the crosses are unknown."""
    require_touch(profile)
    surface, again = profile.surface, "run 'halo calibrate surface --by markers' with it"
    step = profile.steps.get("surface")
    # Only a surface found on the sheet has an error. The virtual table needs no sheet: its targets
    # are around the middle of the view.
    found = step is not None and "error_mm" in step.figures
    if not found and not is_device(profile.camera.serial, SERIAL):
        raise UserError(
            f"the surface of the profile '{profile.name}' is the middle of the camera's view, so "
            f"the positions of the crosses are unknown: put the surface sheet there, and {again}"
        )
    least_mm = 2.0 * (max(x for x, _ in CROSSES_MM) + MARGIN_MM)
    if min(surface.width_mm, surface.height_mm) < least_mm:
        raise UserError(
            f"the surface of the profile '{profile.name}' is {surface.width_mm:.0f} x "
            f"{surface.height_mm:.0f} mm, and the crosses need {least_mm:.0f} x {least_mm:.0f} mm: "
            f"{again}"
        )


def _profile(settings: Settings) -> Profile:
    if not settings.profile:
        raise UserError("evaluate --live: name the profile of this table: --profile P")
    profile = load(profile_path(settings.profile))
    require_crosses(profile)
    return profile
