"""`halo verify`: a grid on the table, a dot under each finger, and the error of each touch.

Rule: touches come from a running service or from a live loop here; drawing and counting are the
same.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field, replace

from halo_calibration.guided.guide import Prompt
from halo_calibration.guided.projector import Screen
from halo_service.app.calibration_ui.verdict import WITHIN_MM
from halo_service.app.hand_detector import HandDetector
from halo_service.app.process import stop_on_signals
from halo_service.app.projector.screens import ScreenRequest, screen_for
from halo_service.app.sources import decide, is_sim, open_source
from halo_service.app.verification.crossings import Finger, Grid
from halo_service.app.verification.remote import grid_from_service
from halo_service.app.verification.session import Verification, grid_over, print_summary
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
from halo_service.virtual.sim_url import parse_sim_url

VIRTUAL_PATIENCE_S = 12.0
"""The virtual user goes on to the next crossing after this time without a touch."""


@dataclass(frozen=True, slots=True)
class VerifyRequest:
    """What the command line asks for."""

    screen: ScreenRequest = field(default_factory=ScreenRequest)
    service: str | None = None
    """Address of a running service, e.g. `osc://127.0.0.1:4256`; None: sense here."""
    within_mm: float = WITHIN_MM


def verify(settings: Settings, request: VerifyRequest) -> int:
    """Verify until all crossings are touched, the display is closed or Ctrl-C; return the exit
    code: 0 if all were touched and 95 % of the touches are within the bound."""
    if request.service is not None:
        grid = grid_from_service(request.service, request.screen)
    elif not settings.profile:
        raise UserError("verify: name a profile with a calibrated projector: --profile desk")
    else:
        grid = _grid_from_source(settings, request)
    return print_summary(grid, request.within_mm)


def _grid_from_source(settings: Settings, request: VerifyRequest) -> Grid:
    """Sense here, until the grid is done."""
    profile = load(profile_path(settings.profile))
    with ExitStack() as stack:
        source, reopen = _open_source(settings, profile.camera.serial)
        stack.callback(source.close)
        require_fit(profile, source.camera)
        screen = stack.enter_context(screen_for(source, request.screen))
        verification = Verification(grid_of(profile, screen), screen)
        state = start(profile, settings.sensing)
        if isinstance(source, VirtualUser):
            with suppress(KeyboardInterrupt):
                follow_virtual_user(source, verification, state, settings)
            return verification.grid
        tracker = TrackerThread(
            lambda: HandDetector(source.camera, profile, settings.tracking, paced=True)
        )
        stack.callback(tracker.close)
        publisher = _VerificationPublisher(verification)
        loop = LiveLoop(source, reopen, tracker, state, publisher)
        publisher.loop = loop
        stop_on_signals(loop.stop)
        loop.run()
    return verification.grid


def follow_virtual_user(
    user: VirtualUser, verification: Verification, state: State, settings: Settings
) -> None:
    """Let the virtual user touch one crossing after another, as fast as frames are rendered."""
    grid, target, since_us = verification.grid, None, 0
    with closing(
        HandDetector(user.camera, state.profile, replace(settings.tracking, max_hands=1))
    ) as detector:
        for touch_frame in replay(user, detector.detect, OURS, state):
            count_touches(verification, touch_frame)
            late = touch_frame.time_us - since_us > 1e6 * VIRTUAL_PATIENCE_S
            if late and target is not None and grid.next == target:
                grid.given_up.add(target)
            if grid.next is None:
                return
            if grid.next != target:
                target, since_us = grid.next, touch_frame.time_us
                user.follow(Prompt("cross", "Touch the ringed crossing.", at_px=grid.pixel(target)))


def grid_of(profile: Profile, screen: Screen) -> Grid:
    """Return the grid for a profile's projector. Raises `UserError` where there is none."""
    if profile.projector is None:
        raise UserError(
            f"verify: the profile '{profile.name}' has no projector: run 'halo calibrate projector'"
        )
    projector, surface = profile.projector, profile.surface
    size_px = projector.width_px, projector.height_px
    matrix = projector.projector_from_surface
    return grid_over(surface.width_mm, surface.height_mm, matrix, size_px, screen)


class _VerificationPublisher:
    """A `Publisher` for one verification; it stops the loop when that is done."""

    def __init__(self, verification: Verification) -> None:
        self._verification = verification
        self.loop: LiveLoop | None = None
        """Set after the loop is made, which needs its publisher first."""

    def frame(self, touch_frame: TouchFrame) -> None:
        """Count the touches of one frame."""
        count_touches(self._verification, touch_frame)
        if self._verification.done:
            assert self.loop is not None  # the loop calls us
            self.loop.stop()

    def scene(self, state: State) -> None:
        """Do nothing: there are no clients."""

    def health(self, health: Health) -> None:
        """Do nothing: there are no clients."""


def count_touches(verification: Verification, touch_frame: TouchFrame) -> None:
    """Draw one frame of touches and count those that begin in it."""
    fingers = [Finger(p.x_mm, p.y_mm, p.state is Touch.TOUCH) for p in touch_frame.pointers]
    downs = [(event.x_mm, event.y_mm) for event in touch_frame.events if event.kind == "down"]
    verification.update(fingers, downs)


def _open_source(settings: Settings, serial: str) -> tuple[Source, Callable[[], Source]]:
    name = decide(serial) if settings.source.name == "auto" else settings.source.name
    if is_sim(name):
        user = VirtualUser(parse_sim_url(name).room)
        return user, lambda: user
    return open_source(replace(settings.source, name=name), serial)
