"""Which hosts may send to the control port.

Rule: pure. A host outside the networks gets no answer at all.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Sequence

from halo_service.errors import UserError

LOOPBACK = ("127.0.0.0/8", "::1/128")


class Networks:
    """The networks that a user allows."""

    def __init__(self, networks: Sequence[str] = LOOPBACK) -> None:
        """`networks`: such as 192.168.1.0/24. Raises `UserError` for one that cannot be read."""
        self._networks = [_network(each) for each in networks]

    def allow(self, host: str) -> bool:
        """Whether an address is in one of them."""
        try:
            address = ipaddress.ip_address(host.partition("%")[0])
        except ValueError:
            return False
        return any(address in network for network in self._networks)


def _network(text: str) -> ipaddress.IPv4Network | ipaddress.IPv6Network:
    try:
        return ipaddress.ip_network(text, strict=False)
    except ValueError as error:
        raise UserError(
            f"control: '{text}' is not a network; write one such as 192.168.1.0/24"
        ) from error
