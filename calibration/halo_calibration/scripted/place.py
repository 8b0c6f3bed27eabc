"""Unattended surface, projector and anchor: what a script's line says of them.

Rule: as `scripted`: a line and its frames become a change of the profile.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice

from halo_calibration.boards.board import ANCHOR, Projected, anchor, crosses
from halo_calibration.boards.graycode import count
from halo_calibration.errors import CalibrationError
from halo_calibration.observe import Observer
from halo_calibration.scripted.script import ScriptStep
from halo_calibration.solvers.dwell import Place, dwells_for, touches
from halo_calibration.solvers.rigid2d import TOUCHES
from halo_calibration.solvers.surface import CORNERS
from halo_calibration.steps import Change, Setup, surface_change
from halo_calibration.steps import place as place_steps
from halo_calibration.steps.place import View, colour_view
from halo_service.profile import Profile
from halo_service.values import Frame

PLACE_STEPS = ("surface", "projector", "anchor")
"""The steps that are taken here."""
LOOKED_AT = 60
"""Frames of a board that are averaged at most: more make the picture no clearer."""
MIDDLE = (0.5, 0.9)
"""Part of the time of a stripe picture in which it is certainly shown: projector and camera are
late by a quarter of a second."""

ObserverFor = Callable[[Profile], Observer]


def place_change(
    setup: Setup,
    line: ScriptStep,
    frames: Iterable[Frame],
    profile: Profile,
    observer_for: ObserverFor,
) -> Change:
    """Calibrate one step. `observer_for` gives an observer for a profile.

    Raises `CalibrationError`.
    """
    if line.step == "surface":
        return _surface(setup, line, frames, profile, observer_for)
    if line.step == "anchor":
        marker = anchor(
            line.words.get("family", ANCHOR.family.name),
            int(line.fields.get("marker", next(iter(ANCHOR.middles_mm)))),
            line.fields.get("size_mm", ANCHOR.size_mm),
        )
        return place_steps.anchor_change(setup, list(islice(frames, LOOKED_AT)), profile, marker)
    return _projector(setup, line, frames, profile, observer_for)


def _surface(
    setup: Setup,
    line: ScriptStep,
    frames: Iterable[Frame],
    profile: Profile,
    observer_for: ObserverFor,
) -> Change:
    by = line.words.get("by", "view")
    if by == "view":
        return surface_change(setup, **line.fields)
    if by == "markers":
        looked = list(islice(frames, LOOKED_AT))
        return place_steps.sheet_change(setup, looked, profile, **line.fields)
    corners = _touched(frames, profile, observer_for(profile), len(CORNERS), "corners")
    return place_steps.corners_change(setup, corners, profile)


def _projector(
    setup: Setup,
    line: ScriptStep,
    frames: Iterable[Frame],
    profile: Profile,
    observer_for: ObserverFor,
) -> Change:
    size_px = int(line.fields["width_px"]), int(line.fields["height_px"])
    by = line.words.get("by", "markers")
    if by == "markers":
        board = Projected(*size_px)
        return place_steps.board_change(setup, islice(frames, LOOKED_AT), profile, board)
    if by == "gray":
        each_s = (line.to_s - line.from_s) / count(*size_px)
        views = list(_views(frames, setup, each_s, count(*size_px)))
        return place_steps.stripes_change(setup, views, profile, size_px)
    touched = _touched(frames, profile, observer_for(profile), len(crosses(*size_px)), "crosses")
    return place_steps.crosses_change(setup, touched, profile, size_px)


def _touched(
    frames: Iterable[Frame], profile: Profile, observer: Observer, marks: int, what: str
) -> list[list[Place]]:
    """Find three touches of each mark, in order."""
    seen = (observer.see(frame) for frame in frames)
    found = touches(seen, dwells_for(profile, profile.camera.fps), marks * TOUCHES)
    if len(found) < marks * TOUCHES:
        raise CalibrationError(
            f"only {len(found)} touches of the {what} were seen, and {marks} x {TOUCHES} are "
            f"needed: rest the finger for half a second each time, lift it by a hand's width in "
            f"between, or correct the script's times"
        )
    return [found[n : n + TOUCHES] for n in range(0, len(found), TOUCHES)]


def _views(frames: Iterable[Frame], setup: Setup, each_s: float, expected: int) -> Iterator[View]:
    """One view of each stripe picture, all shown equally long, one after the other."""
    views: dict[int, list[Frame]] = {number: [] for number in range(expected)}
    first_us: int | None = None
    for frame in frames:
        first_us = frame.time_us if first_us is None else first_us
        number, part = divmod((frame.time_us - first_us) / 1e6 / each_s, 1.0)
        if number in views and MIDDLE[0] <= part <= MIDDLE[1]:
            views[int(number)].append(frame)
    for number, shown in views.items():
        if not shown:
            raise CalibrationError(
                f"no frame shows stripe picture {number + 1} of {expected}: show each for half a "
                f"second, or correct the script's times"
            )
        yield colour_view(shown, setup.camera)
