"""`halo verify`: a grid on the table, a dot under each finger, and how far beside its crossings
one touches.

Rule: fingers come from the running service or from a loop of its own; what is drawn, told and
counted is the same.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field, replace
from types import FrameType

from halo_calibration.guided.guide import Prompt
from halo_calibration.guided.projector import Screen
from halo_service.app.hand_detector import HandDetector
from halo_service.app.projector.screens import ScreenRequest, screen_for
from halo_service.app.sources import decide, open_source
from halo_service.app.verification.crossings import Finger, Grid
from halo_service.app.verification.remote import heard
from halo_service.app.verification.session import Verification, grid_over, summed_up
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, require_fit
from halo_service.runtime.health import Health
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.method import OURS
from halo_service.runtime.replay import replay
from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.sensing import State, start
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.values import Touch, TouchFrame

WITHIN_MM = 5.0
"""Nearly all touches (95 %) lie so near to their crossing, or the exit code is 1: the paper's
touches err by 5.5 mm on average (6.2)."""
VIRTUAL_PATIENCE_S = 12.0
"""A crossing that the virtual user touches for so long without being felt is given up."""


@dataclass(frozen=True, slots=True)
class VerifyRequest:
    """What the command line asks for."""

    screen: ScreenRequest = field(default_factory=ScreenRequest)
    service: str | None = None
    """Where a running service is heard, e.g. `osc://127.0.0.1:4256`; None: sense here."""
    within_mm: float = WITHIN_MM


def verify(settings: Settings, request: VerifyRequest) -> int:
    """Verify until all crossings are touched, the display is closed or Ctrl-C; return the exit
    code: 0 where all were touched and 95 % of the touches lie within the bound."""
    if request.service is not None:
        grid = heard(request.service, request.screen)
    elif not settings.profile:
        raise UserError("verify: name a profile whose projector is calibrated: --profile desk")
    else:
        grid = _sensed(settings, request)
    return summed_up(grid, request.within_mm)


def _sensed(settings: Settings, request: VerifyRequest) -> Grid:
    """Sense here."""
    profile = load(profile_path(settings.profile))
    with ExitStack() as stack:
        source, reopen = _opened(settings)
        stack.callback(source.close)
        require_fit(profile, source.camera)
        screen = stack.enter_context(screen_for(source, request.screen))
        verification = Verification(_grid_of(profile, screen), screen)
        state = start(profile, settings.sensing)
        if isinstance(source, VirtualUser):
            with suppress(KeyboardInterrupt):
                _follow(source, verification, state, settings)
            return verification.grid
        tracker = TrackerThread(lambda: HandDetector(source.camera, profile, settings.tracking))
        stack.callback(tracker.close)
        teller = _Teller(verification)
        loop = LiveLoop(source, reopen, tracker, state, teller)
        teller.loop = loop
        _stop_on_signals(loop)
        loop.run()
    return verification.grid


def _follow(
    user: VirtualUser, verification: Verification, state: State, settings: Settings
) -> None:
    """Let the virtual user touch one crossing after the other; time is their own."""
    grid, asked, since_us = verification.grid, None, 0
    with closing(
        HandDetector(user.camera, state.profile, replace(settings.tracking, max_hands=1))
    ) as eyes:
        for told in replay(user, eyes.look, OURS, state):
            _take(verification, told)
            late = told.time_us - since_us > 1e6 * VIRTUAL_PATIENCE_S
            if late and asked is not None and grid.next == asked:
                grid.given_up.add(asked)
            if grid.next is None:
                return
            if grid.next != asked:
                asked, since_us = grid.next, told.time_us
                user.obey(Prompt("cross", "Touch the ringed crossing.", at_px=grid.pixel(asked)))


def _grid_of(profile: Profile, screen: Screen) -> Grid:
    if profile.projector is None:
        raise UserError(
            f"the profile '{profile.name}' knows no projector: run 'halo calibrate projector'"
        )
    projector, surface = profile.projector, profile.surface
    size_px = projector.width_px, projector.height_px
    matrix = projector.projector_from_surface
    return grid_over(surface.width_mm, surface.height_mm, matrix, size_px, screen)


class _Teller:
    """A `Publisher` that tells a verification alone, and ends the loop with it."""

    def __init__(self, verification: Verification) -> None:
        self._verification = verification
        self.loop: LiveLoop | None = None
        """Stopped at the end; it is made after its publisher."""

    def frame(self, told: TouchFrame) -> None:
        """Take one frame."""
        _take(self._verification, told)
        if self._verification.done:
            assert self.loop is not None  # it is what calls us
            self.loop.stop()

    def scene(self, state: State) -> None:
        """Nobody joins late."""

    def health(self, vitals: Health) -> None:
        """Nobody asks."""


def _take(verification: Verification, told: TouchFrame) -> None:
    fingers = [Finger(p.x_mm, p.y_mm, p.state is Touch.TOUCH) for p in told.pointers]
    downs = [(event.x_mm, event.y_mm) for event in told.events if event.kind == "down"]
    verification.take(fingers, downs)


def _opened(settings: Settings) -> tuple[Source, Callable[[], Source]]:
    name = decide() if settings.source.name == "auto" else settings.source.name
    if name == "sim" or name.startswith("sim:"):
        from halo_service.virtual.sim_url import parse_sim_url

        user = VirtualUser(parse_sim_url(name).room)
        return user, lambda: user
    return open_source(replace(settings.source, name=name))


def _stop_on_signals(loop: LiveLoop) -> None:
    def stop(number: int, where: FrameType | None) -> None:
        loop.stop()

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
