"""Runs a canvas: a thread for each of its nodes, all outputs, a port for clients that ask."""

from __future__ import annotations

import logging
import secrets
import threading
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial

import halo_protocol as wire
from halo_client import ClientError, Follow, ZenohSource
from halo_client.zenoh_input import ZenohInput
from halo_service.app.canvas.merger import Merger
from halo_service.app.canvas.publisher import CanvasPublisher
from halo_service.app.following import Following
from halo_service.app.process import stop_on_signals
from halo_service.app.service.carriers import (
    announce,
    answer_hellos,
    destinations,
    web_server,
    zenoh_output,
)
from halo_service.canvas.layout import Layout
from halo_service.errors import UserError
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.control import ControlPort
from halo_service.outputs.destination import Destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.leases import Leases
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.osc import OscOutput
from halo_service.settings import Settings

log = logging.getLogger(__name__)

TURN_S = 0.05
"""How often clients that ask for the stream are answered."""


def serve_canvas(settings: Settings, layout: Layout, source: ZenohSource) -> None:
    """Serve the canvas on the outputs of the settings until Ctrl-C or SIGTERM.

    `source`: the network of the nodes. Raises `UserError`.
    """
    check(settings, layout)
    wanted = destinations(settings)  # a wrong one ends the command before anything is opened
    session = f"s{secrets.token_hex(4)}"
    stopped = threading.Event()
    stop_on_signals(stopped.set)
    with ExitStack() as stack:
        control = ControlPort(settings.control.host, settings.control.port)
        stack.callback(control.close)
        names = NameWatch(settings.node, session)
        osc = stack.enter_context(closing(OscOutput(wanted)))
        web = web_server(settings, names, control, stack)
        copies = [layout.surface_name(each) for each in layout.projector if each.name]
        zenoh = zenoh_output(settings, names, layout.name, stack, copies)
        carriers: list[Carrier] = [osc, *zenoh, *([web] if web else [])]
        first = wire.first_frame(CLOCK.unix_us())
        frames = FrameEncoder(
            settings.node, session, first, settings.osc.max_bytes, settings.osc.again_ms
        )
        publisher = CanvasPublisher(
            layout, frames, carriers, names, control.port, lambda: sum(z.missing for z in zenoh)
        )
        merger = Merger(layout, publisher)
        stack.callback(_end, merger)
        for placed in layout.surface:
            where = (placed.node, placed.surface)
            handle = partial(merger.handle, where)
            stack.callback(followed(Follow(*where), source, handle).close)
        if settings.web.announce:
            facts = {"surface": layout.name, "rate_hz": "30"}
            stack.callback(announce(settings, names, web, control, **facts).close)
        log.info("canvas '%s' of node %s: %s", layout.name, settings.node, _size(layout))
        log.info("zenoh from %s: %s", ", ".join(source.connect) or source.config, _nodes(layout))
        log.info("zenoh for clients: %s", ", ".join(zenoh[0].listen) if zenoh else "off")
        log.info("osc to %s", ", ".join(map(str, wanted)) or "off")
        log.info("browsers: %s; control port %d", web.url if web else "off", control.port)
        log.info("ready: run 'halo monitor' to see it; Ctrl-C ends")
        leases = Leases(settings.node, session, settings.control.networks)
        leased: list[Destination] = []
        while not stopped.wait(TURN_S):
            before, leased = leased, answer_hellos(control, leases)
            osc.set_leased(leased)
            if any(each not in before for each in leased):
                merger.welcome()
            merger.turn()
        merger.ends = True


def check(settings: Settings, layout: Layout) -> None:
    """Refuse what cannot be served. Raises `UserError`."""
    try:
        wire.check_name(settings.node, "node")
        for each in [layout.name, *map(layout.surface_name, layout.projector)]:
            wire.check_surface(each)
    except wire.ProtocolError as error:
        raise UserError(f"canvas: {error}; change its name in the layout, or --node") from error
    if any(each.node == settings.node for each in layout.surface):
        raise UserError(
            f"canvas: node '{settings.node}' is in the layout, so the canvas would receive itself; "
            "choose another name for the canvas with --node"
        )


def followed(
    follow: Follow, source: ZenohSource, handle: Callable[[list[wire.Event]], None]
) -> Following:
    """Follow one surface from now on. Raises `UserError`."""
    try:
        opened = ZenohInput(replace(source, follow=follow))
    except ClientError as error:
        raise UserError(f"canvas: {error}") from error
    following = Following(opened, follow, handle, "canvas")
    following.start()
    return following


def _end(merger: Merger) -> None:
    merger.end()
    for sentence in merger.status():
        log.info("%s", sentence)


def _size(layout: Layout) -> str:
    return f"{layout.width_mm:g} x {layout.height_mm:g} mm"


def _nodes(layout: Layout) -> str:
    return ", ".join(f"{each.node}/{each.surface}" for each in layout.surface)
