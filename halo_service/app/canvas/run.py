"""Runs a canvas: a thread for each of its nodes, all outputs, a port for clients that ask."""

from __future__ import annotations

import logging
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING

import halo_protocol as wire
from halo_client import ZenohSource
from halo_service.app.canvas.merger import Merger
from halo_service.app.canvas.nodes import follow_nodes
from halo_service.app.canvas.publisher import CanvasPublisher
from halo_service.app.service.carriers import announce, frame_encoder, zenoh_output
from halo_service.app.service.client_ports import ClientPorts
from halo_service.app.versions import zenoh_version
from halo_service.canvas.layout import Layout
from halo_service.errors import UserError
from halo_service.outputs.destination import Destination
from halo_service.outputs.osc import OscOutput
from halo_service.settings import Settings

if TYPE_CHECKING:
    from halo_service.web.announcement import Announcement

log = logging.getLogger(__name__)


def serve_canvas(settings: Settings, layout: Layout, source: ZenohSource) -> None:
    """Serve the canvas on the outputs of the settings until Ctrl-C or SIGTERM.

    `source`: the network of the nodes. Raises `UserError`.
    """
    check(settings, layout)
    with ExitStack() as stack:
        ports = ClientPorts(settings, settings.node, stack)
        osc = stack.enter_context(closing(OscOutput(ports.destinations)))
        copies = [layout.surface_name(each) for each in layout.projector if each.name]
        zenoh = zenoh_output(settings, ports.names, layout.name, stack, copies)
        publisher = CanvasPublisher(
            layout,
            frame_encoder(settings, ports.session),
            [osc, *zenoh, *ports.carriers],
            ports.names,
            ports.control.port,
            lambda: sum(each.missing for each in zenoh),
            zenoh_version() if zenoh else "",
        )
        merger = Merger(layout, publisher)
        stack.callback(_end, merger)
        nodes = [(each.node, each.surface) for each in layout.surface]
        follow_nodes(nodes, source, merger.handle, stack)
        announcement = _announced(settings, layout, ports, stack)
        log.info("canvas '%s' of node %s: %s", layout.name, settings.node, _size(layout))
        network = ", ".join(source.connect) or source.config
        log.info("zenoh from %s: %s", network, ", ".join(map("/".join, nodes)))
        log.info("zenoh for clients: %s", ", ".join(zenoh[0].listen) if zenoh else "off")
        ports.log()
        log.info("ready: run 'halo monitor' to see it; Ctrl-C ends")
        leased: list[Destination] = []
        for now_leased in ports.turns():
            before, leased = leased, now_leased
            osc.set_leased(leased)
            if any(each not in before for each in leased):
                merger.welcome()
            merger.turn()
            if announcement is not None:
                announcement.update(rate_hz=f"{publisher.rate_hz:.0f}")
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


def _announced(
    settings: Settings, layout: Layout, ports: ClientPorts, stack: ExitStack
) -> Announcement | None:
    """Announce the canvas by mDNS; its rate is unknown until a node is there."""
    if not settings.web.announce:
        return None
    facts = {"surface": layout.name, "rate_hz": "0"}
    announcement = announce(settings, ports.names, ports.web, ports.control, **facts)
    stack.callback(announcement.close)
    return announcement


def _end(merger: Merger) -> None:
    merger.end()
    for sentence in merger.summary():
        log.info("%s", sentence)


def _size(layout: Layout) -> str:
    return f"{layout.width_mm:g} x {layout.height_mm:g} mm"
