"""`halo evaluate --live DIR`: what a camera's owner does once, and what came of it.

A guided session on a real table: touch each cross of the printed sheet, rest the finger on pegs,
press on a scale. The crosses lie around the middle of the profile's surface, so that surface must
have been found on the sheet. What is asked for is written down as a script while the frames are
recorded, so that both can be sent to somebody and sensed again by any later version.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

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
"""What the session leaves in its folder."""
TOUCH_S, LEVEL_S = 2.5, 3.0
"""Chosen: long enough to hear of a cross and touch it, and to read a scale."""
READY_S = 5.0
"""Chosen: to put a peg there, or to see the scale come to rest."""
ROUNDS = 2
"""Crosses: at ease, then swiftly. Levels: twice each, as the paper's (5.2.2)."""
MARGIN_MM = 10.0
"""Of the surface around the outer crosses: people touch a few mm beside them (chosen)."""

Line = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Ask:
    """One thing that is asked for."""

    words: str
    ready_s: float
    """Before what is told counts."""
    seconds: float
    step: str
    fields: dict[str, Any]
    """Of the script's line."""


def asked(surface: Surface) -> Iterator[Ask]:
    """Yield the whole session: 32 touches, 10 heights, 10 forces; four minutes.

    The crosses lie around the surface's middle.
    """
    for how in ("once", "once, as short as you can"):
        for number, (x, y) in enumerate(CROSSES_MM):
            words = f"Touch cross {cross_name(number)} {how}."
            place = [surface.width_mm / 2.0 + x, surface.height_mm / 2.0 + y]
            yield Ask(words, 0.0, TOUCH_S, "target", {"target_mm": place})
    for _ in range(ROUNDS):
        for height_mm in HEIGHTS_MM:
            words = f"Rest the fingertip on the peg of {height_mm:g} mm, so that it hides the peg."
            yield Ask(words, READY_S, LEVEL_S, "hover", {"height_mm": height_mm})
        for force_g in FORCES_G:
            words = f"Press until the scale shows {force_g:.0f} g, and hold."
            yield Ask(words, READY_S, LEVEL_S, "pressure", {"force_g": force_g})


def first_light(settings: Settings, folder: Path, colour: bool = True) -> tuple[Path, Path]:
    """Lead through the session; return the recording, with colour or without, and its script.

    Raises `UserError` where the profile does not fit or lacks something, or the folder cannot be
    written; what was recorded is then not kept.
    """
    profile = _profile(settings)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"the folder {folder} cannot be made ({error.strerror}); give --live another one"
        ) from error
    recording, script = folder / RECORDING, folder / SCRIPT
    with ExitStack() as stack:
        source, _ = open_source(settings.source)
        stack.callback(source.close)
        require_fit(profile, source.camera)
        file = stack.enter_context(written(str(script)))
        fps = source.camera.fps
        recorder = stack.enter_context(Recorder(recording, source.camera, fps=fps, colour=colour))
        bar = stack.enter_context(progress(f"recording {recording.name}"))

        def keep(frame: Frame) -> None:
            recorder.write(frame)
            bar.advance()

        lines = conduct(tuple(asked(profile.surface)), source, bar.say, keep)
        file.write(json.dumps(lines, indent=1) + "\n")
    return recording, script


def conduct(
    asks: Sequence[Ask],
    source: Source,
    say: Callable[[str], None],
    keep: Callable[[Frame], None],
) -> list[Line]:
    """Ask for one thing after the other, and keep the frames; return the script.

    Times start at the first frame: frames are kept with 0 as its time. The frame between two asks
    belongs to neither and is left out.
    """
    session = Session(source)
    first_us: int | None = None
    lines: list[Line] = []
    for ask in asks:
        say(ask.words)
        times: list[float] = []
        for frame in session.lasting(ask.ready_s + ask.seconds, ask.step):
            first_us = frame.time_us if first_us is None else first_us
            keep(replace(frame, time_us=frame.time_us - first_us))
            times.append((frame.time_us - first_us) / 1e6)
        if times:
            from_s = times[0] + ask.ready_s
            lines.append({"step": ask.step, "from_s": from_s, "to_s": times[-1], **ask.fields})
    return lines


def require_crosses(profile: Profile) -> None:
    """Raise `UserError` for a profile that cannot tell where the sheet's crosses are."""
    require_touch(profile)
    surface, again = profile.surface, "run 'halo calibrate surface --by markers' with it"
    step = profile.steps.get("surface")
    # Only what was found has an error. On the virtual table nothing need be found: its targets lie
    # around the middle of the view.
    found = step is not None and "error_mm" in step.figures
    if not found and profile.camera.serial != SERIAL:
        raise UserError(
            f"the surface of the profile {profile.name} was laid by the camera's view, so nobody "
            f"knows where the crosses are: lay the surface sheet exactly on theirs, and {again}"
        )
    least_mm = 2.0 * (max(x for x, _ in CROSSES_MM) + MARGIN_MM)
    if min(surface.width_mm, surface.height_mm) < least_mm:
        raise UserError(
            f"the surface of the profile {profile.name} is {surface.width_mm:.0f} x "
            f"{surface.height_mm:.0f} mm, and the crosses want {least_mm:.0f} x {least_mm:.0f} mm: "
            f"{again}"
        )


def _profile(settings: Settings) -> Profile:
    if not settings.profile:
        raise UserError("evaluate --live: name the profile of this table: --profile P")
    profile = load(profile_path(settings.profile))
    require_crosses(profile)
    return profile
