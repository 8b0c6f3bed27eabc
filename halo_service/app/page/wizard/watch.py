"""The two steps that change no profile: judge the camera's placement, and verify touches."""

from __future__ import annotations

import queue

from halo_calibration.guided.guide import PROMPTS
from halo_calibration.guided.projector import Screen
from halo_calibration.steps.camera import camera_report
from halo_calibration.steps.session import Session
from halo_service.app.page.observer import PageObserver
from halo_service.app.page.wizard.page_guide import PageGuide
from halo_service.app.verification.session import Verification, summary_lines
from halo_service.app.verification.verify import (
    WITHIN_MM,
    count_touches,
    follow_virtual_user,
    grid_of,
)
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.sensing import start
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.values import TouchFrame

LOOK_S = 2.1
"""A little more than the frames that a background needs."""
VERIFY_S = 300.0
"""Without a touch for so long, a verification ends."""
WORDS = "VERIFY: touch each crossing that the projector shows, the ringed one next."


def judge_camera(source: Source, guide: PageGuide) -> tuple[bool, str]:
    """Return whether the camera is placed well, and what to change."""
    guide.prompt(PROMPTS["background"])
    session, frames = Session(source), []
    first_us = None
    for frame in session.lasting(LOOK_S, "camera"):
        first_us = frame.time_us if first_us is None else first_us
        guide.live(LOOK_S - (frame.time_us - first_us) / 1e6, True, "looking")
        frames.append(frame)
    report = camera_report(frames, source.camera)
    facts = (
        f"{source.camera.serial}: {report.height_mm / 10:.0f} cm above the table, tilted by "
        f"{report.tilt_deg:.0f} degrees, {100 * report.measured_share:.0f} % of the middle is "
        f"measured, infrared {report.infrared:.0f}."
    )
    return report.quality == "good", "\n".join([facts, *report.advice])


def verify_touches(
    profile: Profile | None,
    source: Source,
    screen: Screen,
    guide: PageGuide,
    settings: Settings,
    observer: PageObserver,
) -> tuple[bool, str]:
    """Return whether the touches are where they should be, and the figures."""
    if profile is None or profile.projector is None:
        raise UserError("verify needs the projector step first: the crossings are projected")
    verification = Verification(grid_of(profile, screen), screen, guide.say)
    if isinstance(source, VirtualUser):
        guide.say(WORDS)
        follow_virtual_user(source, verification, start(profile, settings.sensing), settings)
    else:
        _follow_live(verification, guide, observer)
    lines, good = summary_lines(verification.grid, WITHIN_MM)
    return good, "\n".join(lines)


def _follow_live(verification: Verification, guide: PageGuide, observer: PageObserver) -> None:
    """Count the touches of the running service, until all crossings are touched."""
    frames: queue.Queue[TouchFrame] = queue.Queue(64)

    def take(frame: TouchFrame) -> None:
        if not frames.full():
            frames.put_nowait(frame)

    guide.say(WORDS)
    observer.touch_taps.add(take)
    try:
        idle_s = 0.0
        while not verification.done and idle_s < VERIFY_S:
            touched = len(verification.grid.landings)
            count_touches(verification, frames.get(timeout=10.0))
            idle_s = 0.0 if len(verification.grid.landings) > touched else idle_s + 1.0 / 30.0
            total = len(verification.grid.places)
            guide.live(VERIFY_S - idle_s, True, f"{touched} touches, {total} crossings")
    except queue.Empty:
        raise UserError("the service senses no frames: see its log") from None
    finally:
        observer.touch_taps.discard(take)
