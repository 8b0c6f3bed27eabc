"""The addresses of this machine on its networks."""

from __future__ import annotations

import ipaddress

import ifaddr


def own_addresses() -> frozenset[str]:
    """Return the IPv4 addresses under which other machines reach this one."""
    ours = {str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4}
    return frozenset(each for each in ours if not ipaddress.ip_address(each).is_loopback)
