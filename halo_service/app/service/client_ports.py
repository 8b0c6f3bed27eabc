"""The ports where clients ask for the stream of a canvas, a bridge or a test pattern."""

from __future__ import annotations

import logging
import secrets
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from halo_service.app.process import stop_on_signals
from halo_service.app.service.carriers import answer_hellos, destinations, web_server
from halo_service.outputs import Carrier
from halo_service.outputs.control import ControlPort
from halo_service.outputs.destination import Destination
from halo_service.outputs.leases import Leases
from halo_service.outputs.name_watch import NameWatch
from halo_service.settings import Settings

log = logging.getLogger(__name__)

TURN_S = 0.05
"""How often clients that ask for the stream are answered."""


class ClientPorts:
    """A control port and a server for browsers, in a session of their own."""

    def __init__(
        self, settings: Settings, node: str, stack: ExitStack, only: Sequence[Destination] = ()
    ) -> None:
        """Open them; `stack` closes them. From now on Ctrl-C and SIGTERM end `turns`.

        `only`: send to these alone, and open no server for browsers. Raises `UserError`, for a
        wrong destination before anything is opened.
        """
        self.destinations = list(only) or destinations(settings)
        """Of OSC and TUIO."""
        self.session = f"s{secrets.token_hex(4)}"
        self._stopped = threading.Event()
        stop_on_signals(self._stopped.set)
        self.control = ControlPort(settings.control.host, settings.control.port)
        stack.callback(self.control.close)
        self.names = NameWatch(node, self.session)
        self.web = None if only else web_server(settings, self.names, self.control, stack)
        self._leases = Leases(node, self.session, settings.control.networks)

    @property
    def carriers(self) -> list[Carrier]:
        """The server for browsers, if there is one."""
        return [self.web] if self.web else []

    def log(self) -> None:
        """Log where the stream goes, and where clients ask for it."""
        log.info("osc to %s", ", ".join(map(str, self.destinations)) or "off")
        url = self.web.url if self.web else "off"
        log.info("browsers: %s; control port %d", url, self.control.port)

    def turns(self, period_s: float = TURN_S) -> Iterator[list[Destination]]:
        """Yield where clients want the stream, once each period, until the program shall end."""
        while not self._stopped.wait(period_s):
            yield answer_hellos(self.control, self._leases)
