"""Finds another service with this node's name by mDNS, such as a cloned machine or a second start.

Rule: on the networks where the service itself is announced. Another service counts while it can be
asked: one that was killed is forgotten when its record expires.
"""

from __future__ import annotations

import logging
import threading
import time

from zeroconf import Error as ZeroconfError
from zeroconf import ServiceBrowser, ServiceStateChange, Zeroconf

import halo_protocol as wire
from halo_service.outputs.name_watch import NameWatch

log = logging.getLogger(__name__)

LOOK_S = 2.0
"""How often each is asked; more often than a collision lasts."""
ANSWER_MS = 500
MOST_NAMES = 16
"""Services that are asked; any program can announce more."""


class NameSearch:
    """Reports to a `NameWatch` until it is closed."""

    def __init__(self, zeroconf: Zeroconf, kind: str, names: NameWatch) -> None:
        """`kind`: the service type that our services announce."""
        self._zeroconf, self._kind, self._watch = zeroconf, kind, names
        self._found: set[str] = set()
        self._ended = threading.Event()
        self._browser = ServiceBrowser(zeroconf, kind, handlers=[self._note])
        self._thread = threading.Thread(target=self._run, name="names", daemon=True)
        self._thread.start()

    def has(self, name: str) -> bool:
        """Whether a service is announced under a name."""
        return f"{name}.{self._kind}" in self._found

    def close(self) -> None:
        """End the search; the `Zeroconf` is the caller's."""
        self._ended.set()
        self._browser.cancel()
        self._thread.join()

    def _note(
        self, zeroconf: Zeroconf, service_type: str, name: str, state_change: ServiceStateChange
    ) -> None:
        del zeroconf, service_type
        if state_change is ServiceStateChange.Removed:
            self._found.discard(name)
        elif name.startswith(self._watch.node) and len(self._found) < MOST_NAMES:
            self._found.add(name)  # the node's name, or one that begins with it

    def _run(self) -> None:
        while not self._ended.wait(LOOK_S):
            for name in list(self._found):
                if not self._ended.is_set():
                    self._ask(name)

    def _ask(self, name: str) -> None:
        """Ask one service who it is; another program's answer is ignored."""
        try:
            info = self._zeroconf.get_service_info(self._kind, name, ANSWER_MS)
            facts = info.decoded_properties if info is not None else {}
            node = wire.check_name(facts.get("node") or "", "node")
            session = wire.check_session(facts.get("session") or "")
        except (wire.ProtocolError, ZeroconfError, OSError) as error:
            log.debug("mdns: %s: %s", name[:80], error)
            return
        self._watch.seen(node, session, time.monotonic())
