"""A small profile for the virtual camera, so that it works before any calibration.

The steps of the calibration measure it as for a person: first the empty table, then a finger held
in the four states, with the same tracker and stages as later. The true position of the finger is
not used. Only a live virtual source gets such a profile; a recording does not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace

from halo_calibration import steps
from halo_calibration.errors import CalibrationError
from halo_calibration.guided.guide import PROMPTS
from halo_calibration.observe import Observer
from halo_calibration.solvers.background import WANTED_FRAMES
from halo_calibration.solvers.touch import STATES, HoldObservations
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.user import STATE_VALUES, VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.settings import Settings
from halo_service.values import Frame
from halo_service.virtual.room import Room

SETTLE_S = 1.5
"""Time for the virtual user to reach a state."""
HELD_FRAMES = 15
"""Half a second at 30 a second, a quarter of a person's: the virtual finger does not move."""
FRAMES = WANTED_FRAMES + len(STATES) * HELD_FRAMES
"""Frames that are drawn and measured."""
DATE = "1970-01-01T00:00:00Z"
"""It is measured at every start, so it has no date."""


def virtual_profile(
    room: Room, settings: Settings, advance: Callable[[], None] = lambda: None
) -> Profile:
    """Calibrate on the virtual table; without a sweep, because its fit takes seconds at the start.

    `advance` is called for each of `FRAMES` frames. Raises `UserError` if the states cannot be
    separated.
    """
    user = VirtualUser(room)
    session = Session(user)
    setup = Setup("virtual", user.camera, DATE, settings.sensing, STATE_VALUES)
    try:
        with ExitStack() as stack:
            detector = HandDetector(user.camera, None, replace(settings.tracking, max_hands=1))
            stack.callback(detector.close)
            empty = []
            for frame in session.lasting(WANTED_FRAMES / user.camera.fps, "background"):
                empty.append(frame)
                advance()
            profile = steps.background_change(setup, empty, detector.detect)(None)
            observer = Observer(profile, detector.detect, settings.sensing)
            holds = {state: _held(state, user, session, observer, advance) for state in STATES}
            return steps.touch_change(setup, holds)(profile)
    except CalibrationError as refused:
        raise UserError(
            f"the virtual room of seed {room.seed} on {room.material} cannot be calibrated: "
            f"{refused}; choose another seed or material"
        ) from refused


def _held(
    state: str,
    user: VirtualUser,
    session: Session,
    observer: Observer,
    advance: Callable[[], None],
) -> HoldObservations:
    user.follow(PROMPTS[state])
    user.skip(SETTLE_S)
    frames = _ahead(session.lasting(HELD_FRAMES / user.camera.fps, state))
    return steps.watch_hold(state, frames, HELD_FRAMES, observer, lambda _: advance())


def _ahead(frames: Iterator[Frame]) -> Iterator[Frame]:
    """Draw each frame on the other core while the one before is looked at."""
    with ThreadPoolExecutor(1, "draw") as other_core:
        following = other_core.submit(next, frames, None)
        while (frame := following.result()) is not None:
            following = other_core.submit(next, frames, None)
            yield frame
