"""The virtual Kinect's own small profile, so that it runs before any calibration exists.

It is measured as a user would do it, by the calibration's own steps: the empty room, then a finger
held in the four states, seen by the same tracker and the same stages as later. The finger's true
place is not looked at. Only a live virtual source gets one; a recording never does.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace

from halo_calibration import steps
from halo_calibration.errors import Refused
from halo_calibration.guided.guide import PROMPTS
from halo_calibration.observe import Observation, Observer
from halo_calibration.solvers.touch import STATES, HoldObservations
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.user import STATE_VALUES, VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.settings import Settings
from halo_service.virtual.room import Room

BACKGROUND_S = 2.0
SETTLE_S = 1.5
"""The virtual user has taken a state by then."""
HELD_S = 0.5
"""A quarter of a user's time: the virtual finger holds still."""
DATE = "1970-01-01T00:00:00Z"
"""It is made anew at every start, so it has no date."""


def virtual_profile(room: Room, settings: Settings) -> Profile:
    """Calibrate on the virtual room; without a sweep, for fitting one costs seconds at the start.

    Raises `UserError` when its states cannot be told apart.
    """
    user = VirtualUser(room)
    session = Session(user)
    setup = Setup("virtual", user.camera, DATE, settings.sensing, STATE_VALUES)
    try:
        with ExitStack() as stack:
            eyes = HandDetector(user.camera, None, replace(settings.tracking, max_hands=1))
            stack.callback(eyes.close)
            empty = list(session.lasting(BACKGROUND_S, "background"))
            profile = steps.background_change(setup, empty, eyes.look)(None)
            observer = Observer(profile, eyes.look, settings.sensing)
            holds = {state: _held(state, user, session, observer) for state in STATES}
            return steps.touch_change(setup, holds)(profile)
    except Refused as refused:
        raise UserError(
            f"the virtual room of seed {room.seed} on {room.material} cannot be calibrated: "
            f"{refused}; choose another seed or material"
        ) from refused


def _held(state: str, user: VirtualUser, session: Session, observer: Observer) -> HoldObservations:
    user.obey(PROMPTS[state])
    user.skip(SETTLE_S)
    frames = session.lasting(HELD_S, state)
    return steps.watch_hold(state, frames, session.wanted(HELD_S), observer, _nobody)


def _nobody(seen: Observation | None) -> None:
    """Nobody watches."""
