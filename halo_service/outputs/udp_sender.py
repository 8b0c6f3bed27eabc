"""Datagrams to one destination, by UDP.

Rule: `send` never blocks and never raises for a receiver's sake. Names are looked up by somebody
else (`NameResolver`), so that a slow name server delays no frame.
"""

from __future__ import annotations

import ipaddress
import logging
import socket
import struct

from halo_service.outputs.destination import Destination

log = logging.getLogger(__name__)

Address = tuple[socket.AddressFamily, str]
"""Family and numeric address."""
LOCALHOST: tuple[Address, ...] = (
    (socket.AF_INET, "127.0.0.1"),
    (socket.AF_INET6, "::1"),
)


class UdpSender:
    """A connected socket, opened again when the address changes or refuses.

    Where a name has several addresses (localhost: IPv4, then IPv6), one that refuses is followed
    by the next, until a receiver listens.
    """

    def __init__(self, destination: Destination) -> None:
        self.destination = destination
        self.addresses = literal_addresses(destination.host)
        """Known addresses, set by the resolver; empty: unknown."""
        self.failed = False
        """Set when sending fails, so that the resolver looks again."""
        self.datagrams = self.bytes = 0
        """Sent so far; a receiver may have got fewer."""
        self._using: tuple[Address, ...] = ()
        self._index = 0
        self._socket: socket.socket | None = None
        self._errors: set[int] = set()

    def send(self, datagrams: list[bytes]) -> None:
        """Send; what the system cannot send now is dropped, and the next frame replaces it."""
        if self._using != self.addresses:
            self._close()
            self._using, self._index = self.addresses, 0
        for datagram in datagrams:
            try:
                if self._send(datagram):
                    self.datagrams += 1
                    self.bytes += len(datagram)
            except BlockingIOError:
                return
            except OSError as error:
                self._fail(error)
                return

    def close(self) -> None:
        """Close the socket."""
        self._close()

    def _send(self, datagram: bytes) -> bool:
        """Send; False where there is no address yet."""
        if self._socket is None and self._using:
            self._socket = _opened(self.destination, self._using[self._index % len(self._using)])
        if self._socket is None:
            return False
        try:
            self._socket.send(datagram)
        except ConnectionRefusedError:
            # The answer to an earlier datagram: no program listens there.
            if len(self._using) > 1:
                self._close()
                self._index += 1
                self._socket = _opened(
                    self.destination, self._using[self._index % len(self._using)]
                )
            self._socket.send(datagram)
        return True

    def _fail(self, error: OSError) -> None:
        self._close()
        self._index += 1
        if isinstance(error, ConnectionRefusedError):
            return
        self.failed = True
        if error.errno not in self._errors:
            self._errors.add(error.errno or 0)
            log.warning("osc: cannot send to %s (%s); trying again", self.destination, error)

    def _close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def literal_addresses(host: str) -> tuple[Address, ...]:
    """Return the addresses of a host that needs no lookup; empty for a name."""
    if host.lower() == "localhost":
        return LOCALHOST
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return ()
    return ((socket.AF_INET if address.version == 4 else socket.AF_INET6, host),)


def look_up(host: str) -> tuple[Address, ...]:
    """Ask the system for the addresses of a name, IPv4 first. Blocks; raises `OSError`."""
    found = socket.getaddrinfo(host, None, type=socket.SOCK_DGRAM)
    addresses = dict.fromkeys(
        (socket.AddressFamily(family), str(address[0])) for family, *_, address in found
    )
    return tuple(sorted(addresses, key=lambda each: each[0] != socket.AF_INET))


def _opened(destination: Destination, address: Address) -> socket.socket:
    family, host = address
    sender = socket.socket(family, socket.SOCK_DGRAM)
    try:
        sender.setblocking(False)
        if family == socket.AF_INET:
            sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        if ipaddress.ip_address(host.partition("%")[0]).is_multicast:
            _set_multicast(sender, family, destination)
        sender.connect((host, destination.port))
    except OSError:
        sender.close()
        raise
    return sender


def _set_multicast(sender: socket.socket, family: int, destination: Destination) -> None:
    interface = destination.interface
    if family == socket.AF_INET6:
        sender.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, destination.ttl)
        if interface:
            index = socket.if_nametoindex(interface)
            sender.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, index)
        return
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, destination.ttl)
    if interface:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, _ipv4_interface(interface))


def _ipv4_interface(interface: str) -> bytes:
    """Return an interface as IP_MULTICAST_IF wants it: an address, or an index (ip_mreqn)."""
    try:
        return socket.inet_aton(interface)
    except OSError:
        index = socket.if_nametoindex(interface)
    return struct.pack("@4s4si", bytes(4), bytes(4), index)
