"""`halo serve`: a source in, touches out."""

from __future__ import annotations

import logging
import secrets
import signal
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from types import FrameType

import halo_protocol as wire
from halo_service.app.hand_detector import HandDetector, model_for
from halo_service.app.service.control_handler import ControlHandler
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.app.service.publisher import Publisher
from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.control import ControlPort
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.osc import OscOutput, destination
from halo_service.outputs.settings import LISTEN
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, require_fit
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.sensing import DEFAULT_SURFACE, start
from halo_service.settings import Settings
from halo_service.sources import Source

log = logging.getLogger(__name__)


def serve(settings: Settings) -> None:
    """Run the service until Ctrl-C, SIGTERM or the end of a recording."""
    node = _node(settings.node)
    with ExitStack() as stack:
        control = ControlPort(settings.control.host, settings.control.port)
        stack.callback(control.close)
        kept = load(profile_path(settings.profile)) if settings.profile else None
        surface = kept.surface.name if kept else DEFAULT_SURFACE[0]
        session = f"s{secrets.token_hex(4)}"
        names = NameWatch(node, session)
        carriers = _carriers(settings, names, surface, stack)
        source, reopen = open_source(settings.source)
        stack.callback(source.close)
        profile = profile_for(source, kept, settings)
        frames = FrameEncoder(node, session, wire.first_frame(CLOCK.unix_us()))
        publisher = Publisher(
            frames, carriers, source.kind, source.camera, surface, control.port, names
        )
        tracker = _tracker(source, profile, settings)
        if tracker is not None:
            stack.callback(tracker.close)
        state = start(profile, settings.sensing)
        folder = profile_path(settings.profile) if settings.profile else None
        keeper = ProfileReloader(folder, source.camera, profile)
        stack.callback(keeper.close)
        orders = ControlHandler(control, keeper)
        again = partial(_same_again, reopen, source.camera)
        loop = LiveLoop(source, again, tracker, state, publisher, orders.obey, keeper.watch)
        _stop_on_signals(loop)
        _greet(settings, source, profile, node, control.port)
        loop.run()


def profile_for(source: Source, kept: Profile | None, settings: Settings) -> Profile | None:
    """Return the profile to sense with: the user's, the virtual sensor's own, or none."""
    if kept is not None:
        require_fit(kept, source.camera)
        return kept
    if source.kind == "virtual":
        log.info("profile: measuring the virtual room, a few seconds")
        from halo_service.app.virtual_user.profile import virtual_profile
        from halo_service.virtual.live import VirtualKinect

        assert isinstance(source, VirtualKinect)  # nothing else calls itself virtual
        return virtual_profile(source.room, settings)
    log.warning(
        "profile: none, so frames carry no pointers until this place is calibrated: "
        "run 'halo calibrate --profile desk', then start with --profile desk"
    )
    return None


def _node(name: str) -> str:
    try:
        return wire.check_name(name, "node")
    except wire.ProtocolError as error:
        raise UserError(f"{error}; set it with --node or in halo.toml") from error


def _tracker(source: Source, profile: Profile | None, settings: Settings) -> TrackerThread | None:
    """Make the hand tracker; a recording without a profile has no use for hands, and needs none."""
    if profile is None and not settings.profile and source.kind == "recording":
        return None
    model_for(settings.tracking)  # here, so that a model that cannot be had is told at the start
    return TrackerThread(lambda: HandDetector(source.camera, profile, settings.tracking))


def _same_again(reopen: Callable[[], Source], camera: Camera) -> Source:
    """Open the source that was lost; another device in its place is not it."""
    source = reopen()
    if source.camera.serial != camera.serial:
        source.close()
        raise UserError(f"camera {source.camera.serial} is not {camera.serial}, which was lost")
    return source


def _carriers(
    settings: Settings, names: NameWatch, surface: str, stack: ExitStack
) -> list[Carrier]:
    carriers: list[Carrier] = []
    if settings.osc.enabled:
        osc = OscOutput([destination(each) for each in settings.osc.destinations])
        carriers.append(stack.enter_context(closing(osc)))
    if settings.zenoh.enabled:
        from halo_service.outputs.zenoh import ZenohOutput

        carriers.append(
            stack.enter_context(closing(ZenohOutput(settings.zenoh, names.node, surface, names)))
        )
    return carriers


def _stop_on_signals(loop: LiveLoop) -> None:
    def stop(number: int, where: FrameType | None) -> None:
        loop.stop()

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)


def _greet(
    settings: Settings, source: Source, profile: Profile | None, node: str, control_port: int
) -> None:
    osc = ", ".join(settings.osc.destinations) if settings.osc.enabled else "off"
    set_here = ", ".join(settings.zenoh.listen + settings.zenoh.connect)
    zenoh = set_here or settings.zenoh.config or ", ".join(LISTEN)
    log.info("source %s %s, serial %s", source.kind, settings.source.name, source.camera.serial)
    log.info("calibration %s", profile.calibrated if profile else "none")
    log.info("osc to %s; zenoh %s", osc, zenoh if settings.zenoh.enabled else "off")
    log.info("node %s, control port %d; Ctrl-C ends", node, control_port)
