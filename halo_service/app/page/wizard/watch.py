"""Verification as a step of the set-up: it measures nothing for the profile but how good it is."""

from __future__ import annotations

import queue
import time

from halo_calibration.guided.projector import Screen
from halo_service.app.page.observer import PageObserver
from halo_service.app.page.wizard.page_guide import PageGuide
from halo_service.app.verification.crossings import Grid
from halo_service.app.verification.session import Verification
from halo_service.app.verification.verify import count_touches, follow_virtual_user, grid_of
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.sensing import start
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.values import TouchFrame

VERIFY_S = 300.0
"""Without a touch for so long, a verification ends."""
SILENCE_S = 10.0
READ_S = 0.25
"""Time between two looks whether the step was stopped."""
WORDS = "VERIFY: touch each crossing that the projector shows, the ringed one next."


def verify_touches(
    profile: Profile | None,
    source: Source,
    screen: Screen,
    guide: PageGuide,
    settings: Settings,
    observer: PageObserver,
) -> Grid:
    """Return the grid with its touches. Raises `UserError`."""
    if profile is None or profile.projector is None:
        raise UserError("verify needs the projector step first: the crossings are projected")
    guide.explain(WORDS)

    def watch(grid: Grid) -> None:
        total = len(grid.places)
        touched = len({landing.crossing for landing in grid.landings})
        guide.count(touched, total, f"{touched} of {total} crossings touched")

    verification = Verification(grid_of(profile, screen), screen, guide.say, watch)
    watch(verification.grid)
    if isinstance(source, VirtualUser):
        follow_virtual_user(source, verification, start(profile, settings.sensing), settings)
    else:
        _follow_live(verification, guide, observer)
    return verification.grid


def _follow_live(verification: Verification, guide: PageGuide, observer: PageObserver) -> None:
    """Count the touches of the running service, until all crossings are touched."""
    frames: queue.Queue[TouchFrame] = queue.Queue(64)

    def put(frame: TouchFrame) -> None:
        if not frames.full():
            frames.put_nowait(frame)

    observer.touch_taps.add(put)
    touched, touched_s = 0, time.monotonic()
    frame_s = touched_s
    try:
        while not verification.done and time.monotonic() - touched_s < VERIFY_S:
            guide.check()
            try:
                count_touches(verification, frames.get(timeout=READ_S))
            except queue.Empty:
                if time.monotonic() - frame_s > SILENCE_S:
                    raise UserError("the service senses no frames: see its log") from None
                continue
            frame_s = time.monotonic()
            if len(verification.grid.landings) > touched:
                touched, touched_s = len(verification.grid.landings), frame_s
    finally:
        observer.touch_taps.discard(put)
