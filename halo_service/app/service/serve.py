"""`halo serve`: a source in, touches out."""

from __future__ import annotations

import logging
import secrets
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING

import halo_protocol as wire
from halo_service.app.hand_detector import HandDetector, model_for
from halo_service.app.page.parts import PageRequest, Parts
from halo_service.app.process import stop_on_signals
from halo_service.app.progress import progress
from halo_service.app.service.carriers import (
    announce,
    destinations,
    frame_encoder,
    web_server,
    zenoh_output,
)
from halo_service.app.service.control_handler import ControlHandler
from halo_service.app.service.fit_watcher import FitWatcher
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.app.service.publisher import Publisher
from halo_service.app.service.systemd import Notifier
from halo_service.app.sources import open_source
from halo_service.app.versions import zenoh_version
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera
from halo_service.outputs import Carrier
from halo_service.outputs.control import ControlPort
from halo_service.outputs.destination import EXAMPLE, parse_destination
from halo_service.outputs.leases import Leases
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.osc import OscOutput
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, require_fit
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.sensing import DEFAULT_SURFACE, State, adopt, start
from halo_service.settings import Settings
from halo_service.sources import ColourSwitch, Source
from halo_service.sources.switched import SwitchedSource
from halo_service.values import Frame

if TYPE_CHECKING:
    from halo_service.app.page.page import ControlPage
    from halo_service.virtual.room import Room

log = logging.getLogger(__name__)


def serve(
    settings: Settings, settings_from: str = "", page_request: PageRequest | None = None
) -> None:
    """Run the service until Ctrl-C, SIGTERM or the end of a recording.

    `settings_from`: which file the settings are from, for the log; `page_request`: what the
    command line says of the control page.
    """
    node = _node(settings.node)
    wanted = destinations(settings)  # a wrong one ends the command before anything is opened
    systemd = Notifier()
    with ExitStack() as stack:
        stack.callback(systemd.stopping)
        control = ControlPort(settings.control.host, settings.control.port)
        stack.callback(control.close)
        saved = load(profile_path(settings.profile)) if settings.profile else None
        surface = saved.surface.name if saved else DEFAULT_SURFACE[0]
        source, reopen = open_source(settings.source, saved.camera.serial if saved else "")
        switched = SwitchedSource(source)
        stack.callback(switched.close)
        session = f"s{secrets.token_hex(4)}"
        names = NameWatch(node, session)
        leases = Leases(node, session, settings.control.networks)
        osc = stack.enter_context(closing(OscOutput(wanted)))
        web = web_server(settings, names, control, stack)
        zenoh = zenoh_output(settings, names, surface, stack)
        endpoints = (*zenoh[0].listen, *settings.zenoh.connect) if zenoh else ()
        carriers: list[Carrier] = [osc, *zenoh, *([web] if web else [])]
        profile = profile_for(source, saved, settings)
        folder = profile_path(settings.profile) if settings.profile else None
        reloader = ProfileReloader(folder, source.camera, profile)
        stack.callback(reloader.close)
        fit = FitWatcher(lambda: reloader.profile)
        stack.callback(fit.close)
        publisher = Publisher(
            frame_encoder(settings, session),
            carriers,
            source.kind,
            source.camera,
            surface,
            control.port,
            names,
            lambda: fit.fit,
            lambda: reloader.write_errors,
            lambda: sum(each.missing for each in zenoh),
            zenoh_version() if zenoh else "",
        )
        tracker = _tracker(source, reloader, settings)
        if tracker is not None:
            stack.callback(tracker.close)
            reloader.on_change = tracker.reload
        paused = threading.Event()
        parts = Parts(settings, switched, osc, web, endpoints, reloader, lambda: fit.fit, paused)
        page = _page(parts, page_request or PageRequest(), publisher, stack)

        def control_and_report(state: State, opened: Source | None) -> State:
            systemd.alive()
            source = switched.source if opened is not None else None
            state = handler.handle(state, source)
            if publisher.kind != switched.kind:
                publisher.kind = switched.kind
                state = adopt(state, state.profile) if state.profile else state
            if isinstance(source, ColourSwitch):
                shown = page is not None and page.observer.needs_colour
                source.with_colour(shown or _needs_colour(reloader.profile))
            return page.observer.turn(state) if page else state

        def watch(frame: Frame) -> None:
            reloader.watch(frame)
            fit.watch(frame)
            if page is not None:
                page.observer.watch(frame)

        handler = ControlHandler(control, reloader, leases, osc, paused)
        loop = LiveLoop(
            switched,
            lambda: switched.reopened(_reopen_same(reopen, source.camera)),
            tracker,
            start(profile, settings.sensing),
            page.observer if page else publisher,
            control_and_report,
            watch,
            paused=paused,
        )
        if web is not None:
            web.nodes = handler.nodes
        if settings.web.announce:
            facts = {"surface": surface, "rate_hz": f"{source.camera.fps:g}"}
            stack.callback(announce(settings, names, web, control, **facts).close)
        stop_on_signals(loop.stop)
        log.info("settings: %s", settings_from)
        if page is not None:
            page.announce(page_request is not None and page_request.opens)
        web_url = web.url if web else ""
        _log_start(settings, source, profile, node, control.port, web_url, endpoints)
        systemd.ready()
        loop.run()


def profile_for(source: Source, saved: Profile | None, settings: Settings) -> Profile | None:
    """Return the profile to use: the saved one, the virtual camera's own, or None."""
    if saved is not None:
        require_fit(saved, source.camera)
        return saved
    if source.kind == "virtual":
        from halo_service.app.virtual_user.cache import cached_profile
        from halo_service.virtual.live import VirtualKinect

        assert isinstance(source, VirtualKinect)  # the only virtual source here
        return cached_profile(source.room, settings, _measured)
    log.warning(
        "profile: none, so frames have no pointers; run 'halo calibrate --profile desk', "
        "then start with --profile desk"
    )
    return None


def _measured(room: Room, settings: Settings) -> Profile:
    """Calibrate on the virtual table."""
    from halo_service.app.virtual_user.profile import FRAMES, virtual_profile

    log.info("profile: measuring the virtual table; this takes 5 to 20 s, once for each room")
    with progress("measuring the virtual table", FRAMES) as bar:
        return virtual_profile(room, settings, bar.advance)


def _node(name: str) -> str:
    try:
        return wire.check_name(name, "node")
    except wire.ProtocolError as error:
        raise UserError(f"{error}; set it with --node or in halo.toml") from error


def _tracker(source: Source, reloader: ProfileReloader, settings: Settings) -> TrackerThread | None:
    """Make the hand tracker; None for a recording without a profile, which needs no hands."""
    if reloader.profile is None and not settings.profile and source.kind == "recording":
        return None
    model_for(settings.tracking)  # here, so that a missing model is an error at the start
    camera, tracking = source.camera, settings.tracking
    return TrackerThread(lambda: HandDetector(camera, reloader.profile, tracking, paced=True))


def _needs_colour(profile: Profile | None) -> bool:
    """Whether the hand tracker looks at colour, or an anchor is watched for in it."""
    if profile is None or profile.anchor is not None:
        return True
    return not profile.background.valid.any()


def _reopen_same(reopen: Callable[[], Source], camera: Camera) -> Source:
    """Open the lost source again. Raises `UserError` for another device."""
    source = reopen()
    if source.camera.serial != camera.serial:
        source.close()
        raise UserError(f"camera {source.camera.serial} is not the lost camera {camera.serial}")
    return source


def _page(
    parts: Parts, request: PageRequest, publisher: Publisher, stack: ExitStack
) -> ControlPage | None:
    """Open the control page; None where it is off."""
    if not parts.settings.page.enabled:
        return None
    from halo_service.app.page.page import ControlPage

    page = ControlPage(parts, request, publisher)
    stack.callback(page.close)
    return page


def _log_start(
    settings: Settings,
    source: Source,
    profile: Profile | None,
    node: str,
    control_port: int,
    web_url: str,
    zenoh: Sequence[str],
) -> None:
    """Log where everything is, and last how to see it. `web_url`: empty without a web server."""
    osc = ", ".join(map(str, destinations(settings))) or "off"
    kind = "virtual camera" if source.kind == "virtual" else source.kind
    log.info("source: %s (%s), serial %s", kind, settings.source.name, source.camera.serial)
    log.info("calibration %s", profile.calibrated if profile else "none")
    log.info("osc to %s; zenoh %s", osc, ", ".join(zenoh) or "off")
    log.info("browsers: %s; node %s, control port %d", web_url or "off", node, control_port)
    command = _monitor(settings, web_url, control_port)
    log.info("ready: run '%s' to see it; Ctrl-C ends", command)


def _monitor(settings: Settings, web_url: str, control_port: int) -> str:
    """Return the command that shows the touches: by OSC where it goes to the default place."""
    if parse_destination(EXAMPLE) in destinations(settings):
        return "halo monitor"
    if web_url:
        return f"halo monitor --from {web_url}"
    host = settings.control.host
    host = "127.0.0.1" if host == "0.0.0.0" else f"[{host}]" if ":" in host else host
    return f'halo monitor --from "osc://?hello={host}:{control_port}"'
