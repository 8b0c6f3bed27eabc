"""Announces the service by mDNS, so that other programs find it by name.

Rule: only where its ports are open: a port of the loopback is announced on the loopback alone.
"""

from __future__ import annotations

import ipaddress
import logging
import threading
import time
from collections.abc import Mapping
from typing import NamedTuple

from zeroconf import Error as ZeroconfError
from zeroconf import InterfaceChoice, IPVersion, ServiceInfo, Zeroconf

from halo_service.outputs.name_watch import NameWatch
from halo_service.web.addresses import own_addresses
from halo_service.web.name_search import NameSearch

log = logging.getLogger(__name__)

OSC, OSCQUERY = "_osc._udp.local.", "_oscjson._tcp.local."
"""Service types of the control port and of OSCQuery."""
LISTEN_S = 1.5
"""How long to look for others before a name is used."""
LASTS_S = 20
"""Seconds until others forget where a service was that did not withdraw its announcement."""


class Port(NamedTuple):
    """An open port of the service."""

    kind: str
    """`OSC` or `OSCQUERY`."""
    host: str
    """The IPv4 address that it listens on; 0.0.0.0 is all of this machine."""
    number: int


class Announcement:
    """Stays until it is closed; a network without mDNS costs a line in the log."""

    def __init__(self, names: NameWatch, ports: list[Port], facts: Mapping[str, str]) -> None:
        """`names`: this service's, which also gets others of the same name; `facts`: what a
        program can read before it connects, such as the surface."""
        self._names = names
        self._ports, self._facts = ports, dict(facts)
        self._name = names.node
        self._announcers: list[Zeroconf] = []
        self._announced: list[tuple[Zeroconf, ServiceInfo]] = []
        self._searches: list[NameSearch] = []
        self._thread = threading.Thread(target=self._announce, name="mdns", daemon=True)
        self._thread.start()

    def update(self, **facts: str) -> None:
        """Announce changed facts, in the background; nothing is sent if they are as before."""
        if facts.items() <= self._facts.items():
            return
        self._facts |= facts
        before = self._thread
        self._thread = threading.Thread(
            target=self._announce_again, args=(before,), name="mdns", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Withdraw the announcement."""
        self._thread.join()
        for search in self._searches:
            search.close()
        for announcer in self._announcers:
            try:
                announcer.unregister_all_services()
            except (OSError, ZeroconfError) as error:
                log.debug("mdns: %s", error)
            announcer.close()

    def _announce(self) -> None:
        for port in self._ports:
            try:
                self._register(port)
            except (OSError, ZeroconfError) as error:
                reason = error or type(error).__name__
                log.warning("mdns: other programs cannot find this service by name (%s)", reason)

    def _register(self, port: Port) -> None:
        addresses = _addresses(port.host)
        if not addresses:
            log.debug("mdns: %s is not announced; only IPv4 addresses are", port.host)
            return
        chosen = InterfaceChoice.All if port.host == "0.0.0.0" else addresses
        announcer = Zeroconf(interfaces=chosen, ip_version=IPVersion.V4Only)
        self._announcers.append(announcer)
        if port.kind == OSC:
            self._searches.append(NameSearch(announcer, OSC, self._names))
            self._choose_name(self._searches[-1])
        info = self._info(port.kind, f"{self._name}.{port.kind}", port.number, addresses)
        announcer.register_service(info, allow_name_change=True)
        self._announced.append((announcer, info))

    def _info(self, kind: str, name: str, port: int | None, addresses: list[str]) -> ServiceInfo:
        node, session = self._names.node, self._names.session
        return ServiceInfo(
            kind,
            name,
            port=port,
            parsed_addresses=addresses,
            properties={"node": node, "session": session, **self._facts},
            server=f"{node}-{session}.local.",
            host_ttl=LASTS_S,
        )

    def _announce_again(self, before: threading.Thread) -> None:
        """Announce the present facts, after a thread that announces earlier ones."""
        before.join()
        for announcer, info in self._announced:
            changed = self._info(info.type, info.name, info.port, info.parsed_addresses())
            try:
                announcer.update_service(changed)
            except (OSError, ZeroconfError) as error:
                log.debug("mdns: %s", error)

    def _choose_name(self, search: NameSearch) -> None:
        """Use the node's name, or where it is taken one that no other service can have.

        mDNS would notice a taken name itself, but on a busy machine not always in time.
        """
        until_s = time.monotonic() + LISTEN_S
        while time.monotonic() < until_s:
            if search.has(self._name):
                self._name = f"{self._names.node}-{self._names.session}"
                return
            time.sleep(LISTEN_S / 20)


def _addresses(host: str) -> list[str]:
    """Return the IPv4 addresses under which a listening host is reached."""
    if host == "localhost":
        return ["127.0.0.1"]
    try:
        address = ipaddress.IPv4Address(host)
    except ValueError:
        return []
    if not address.is_unspecified:
        return [host]
    return sorted(own_addresses())
