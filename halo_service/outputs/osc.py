"""OSC over UDP to fixed destinations."""

from __future__ import annotations

import logging
import socket

from halo_service.errors import UserError

log = logging.getLogger(__name__)


def destination(text: str) -> tuple[str, int]:
    """Read `host:port`. Raises `UserError` where it is none."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise UserError(f"osc: '{text}' is no destination; write host:port, like 127.0.0.1:9000")
    return host.strip("[]"), int(port)


class OscOutput:
    """Sends every datagram to every destination. UDP: nobody is asked whether it arrived."""

    def __init__(self, destinations: list[tuple[str, int]]) -> None:
        """`destinations`: host and port. Raises `UserError` for a host that has no address."""
        self._destinations = [_resolve(host, port) for host, port in destinations]
        self._sockets = {
            family: socket.socket(family, socket.SOCK_DGRAM)
            for family in {family for family, _ in self._destinations}
        }
        for each in self._sockets.values():
            each.setblocking(False)
        self._refused: set[tuple[str, int]] = set()

    def send(self, kind: str, datagrams: list[bytes]) -> None:
        """Send to all. What the system cannot take now is dropped: the next frame heals it."""
        del kind
        for family, address in self._destinations:
            for datagram in datagrams:
                try:
                    self._sockets[family].sendto(datagram, address)
                except OSError as error:
                    self._tell_once(address, error)

    def close(self) -> None:
        """Close the sockets."""
        for each in self._sockets.values():
            each.close()

    def _tell_once(self, address: tuple[str, int], error: OSError) -> None:
        if address not in self._refused:
            self._refused.add(address)
            log.warning("osc: cannot send to %s:%d (%s); going on", *address[:2], error)


def _resolve(host: str, port: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except OSError as error:
        raise UserError(
            f"osc: the host '{host}' has no address ({error}); check [osc] destinations"
        ) from error
    return family, (str(address[0]), port)
