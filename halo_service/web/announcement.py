"""Announces the service by mDNS, so that other programs find it by name.

Rule: only where its ports are open: a port of the loopback is announced on the loopback alone.
"""

from __future__ import annotations

import ipaddress
import logging
import threading
from collections.abc import Mapping
from typing import NamedTuple

import ifaddr
from zeroconf import Error as ZeroconfError
from zeroconf import InterfaceChoice, IPVersion, ServiceInfo, Zeroconf

log = logging.getLogger(__name__)

OSC, OSCQUERY = "_osc._udp.local.", "_oscjson._tcp.local."
"""Service types of the control port and of OSCQuery."""


class Port(NamedTuple):
    """An open port of the service."""

    kind: str
    """`OSC` or `OSCQUERY`."""
    host: str
    """The IPv4 address that it listens on; 0.0.0.0 is all of this machine."""
    number: int


class Announcement:
    """Stays until it is closed; a network without mDNS costs a line in the log."""

    def __init__(
        self, node: str, session: str, ports: list[Port], facts: Mapping[str, str]
    ) -> None:
        """`facts`: what a program can read before it connects, such as the surface."""
        self._node, self._session = node, session
        self._ports, self._facts = ports, dict(facts)
        self._announcers: list[Zeroconf] = []
        self._thread = threading.Thread(target=self._announce, name="mdns", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Withdraw the announcement."""
        self._thread.join()
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
        announcer.register_service(
            ServiceInfo(
                port.kind,
                f"{self._node}.{port.kind}",
                port=port.number,
                parsed_addresses=addresses,
                properties={"node": self._node, "session": self._session, **self._facts},
                server=f"{self._node}-{self._session}.local.",
            ),
            allow_name_change=True,
        )


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
    ours = {str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4}
    return sorted(each for each in ours if not ipaddress.ip_address(each).is_loopback)
