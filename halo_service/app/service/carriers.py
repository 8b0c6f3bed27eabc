"""Opens the outputs that the settings name: OSC, Zenoh and the server for browsers."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING

import halo_protocol as wire
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.control import ControlPort
from halo_service.outputs.destination import Destination, parse_destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.leases import Leases
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import Outgoing
from halo_service.runtime.error_log import ErrorLog
from halo_service.settings import Settings

if TYPE_CHECKING:
    from halo_service.outputs.zenoh import ZenohOutput
    from halo_service.web.announcement import Announcement
    from halo_service.web.server import WebServer


def destinations(settings: Settings) -> list[Destination]:
    """Read the destinations of OSC and TUIO. Raises `UserError` for a bad one."""
    osc = settings.osc.destinations if settings.osc.enabled else ()
    return [
        *(parse_destination(each) for each in osc),
        *(parse_destination(each, "tuio") for each in settings.tuio.destinations),
    ]


def zenoh_output(
    settings: Settings,
    names: NameWatch,
    surface: str,
    stack: ExitStack,
    copies: Sequence[str] = (),
) -> list[ZenohOutput]:
    """Open the Zenoh session; empty where it is off. `copies`: names of further surfaces."""
    if not settings.zenoh.enabled:
        return []
    from halo_service.outputs.zenoh import ZenohOutput

    output = ZenohOutput(settings.zenoh, names.node, surface, names, copies)
    return [stack.enter_context(closing(output))]


def frame_encoder(settings: Settings, session: str) -> FrameEncoder:
    """Return what makes frames messages, in a session that begins now."""
    first = wire.first_frame(CLOCK.unix_us())
    osc = settings.osc
    return FrameEncoder(settings.node, session, first, osc.max_bytes, osc.again_ms)


class Carriers:
    """All outputs of a program: an error of one does not hold up the others."""

    def __init__(self, carriers: Sequence[Carrier]) -> None:
        self._carriers = carriers
        self._errors = ErrorLog()

    def send(self, outgoing: Outgoing) -> None:
        """Send on each of them."""
        for carrier in self._carriers:
            with self._errors.guard(f"output {type(carrier).__name__}"):
                carrier.send(outgoing)


def answer_hellos(control: ControlPort, leases: Leases) -> list[Destination]:
    """Answer the clients that ask for the stream; return where streams go now."""
    now_s = time.monotonic()
    for message in control.drain():
        for datagram, _ in leases.handle(message, now_s):
            message.answer(datagram)
    leases.expire(now_s)
    return leases.destinations


def web_server(
    settings: Settings, names: NameWatch, control: ControlPort, stack: ExitStack
) -> WebServer | None:
    """Open the server for browsers; None where it is off."""
    if not settings.web.enabled:
        return None
    from halo_service.web.server import WebServer

    elsewhere = settings.control.host not in (settings.web.host, "0.0.0.0", "::")
    server = WebServer(
        settings.web,
        names.node,
        names.session,
        control.put,
        control.port,
        settings.control.host if elsewhere else "",
    )
    stack.callback(server.close)
    return server


def announce(
    settings: Settings, names: NameWatch, web: WebServer | None, control: ControlPort, **facts: str
) -> Announcement:
    """Announce the ports by mDNS, each where its host can be reached; `facts`: text entries."""
    from halo_service.web.announcement import OSC, OSCQUERY, Announcement, Port

    ports = [Port(OSC, settings.control.host, control.port)]
    if web is not None:
        ports.append(Port(OSCQUERY, settings.web.host, web.port))
    return Announcement(names, ports, facts)
