"""The network cards of this machine, and the firewalls that are known to be on.

Rule: it reads the system and changes nothing.
"""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from pathlib import Path

import ifaddr

UFW = Path("/etc/ufw/ufw.conf")
FIREWALLD = Path("/run/firewalld")


@dataclass(frozen=True, slots=True)
class Card:
    """A network interface with its IPv4 addresses."""

    name: str
    addresses: tuple[ipaddress.IPv4Interface, ...]

    @property
    def is_loopback(self) -> bool:
        """Whether it only reaches this machine."""
        return all(each.ip.is_loopback for each in self.addresses)

    def __str__(self) -> str:
        return f"{self.name} {' '.join(map(str, self.addresses))}"


def cards() -> list[Card]:
    """Return all interfaces with an IPv4 address."""
    found = []
    for adapter in ifaddr.get_adapters():
        addresses = tuple(
            ipaddress.IPv4Interface(f"{each.ip}/{each.network_prefix}")
            for each in adapter.ips
            if each.is_IPv4
        )
        if addresses:
            found.append(Card(adapter.nice_name, addresses))
    return found


def firewall_hint(port: int, protocol: str) -> str:
    """Return how to open a port where a firewall is known to be on; else empty."""
    if "ENABLED=yes" in _text(UFW):
        return f"ufw is on: sudo ufw allow {port}/{protocol}"
    if FIREWALLD.is_dir():
        return f"firewalld is on: sudo firewall-cmd --add-port={port}/{protocol}"
    return ""


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""
