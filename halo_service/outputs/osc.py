"""OSC over UDP to fixed destinations."""

from __future__ import annotations

import logging
import socket

from halo_service.errors import UserError

log = logging.getLogger(__name__)


def destination(text: str) -> tuple[str, int]:
    """Read `host:port`. Raises `UserError` for anything else."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise UserError(
            f"osc: '{text}' is not a destination; write host:port, such as 127.0.0.1:4256"
        )
    return host.strip("[]"), int(port)


class OscOutput:
    """Sends every datagram to every destination, by UDP, without confirmation."""

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
        """Send to all. A datagram that the system cannot send now is dropped; the next frame
        replaces it."""
        del kind
        for family, address in self._destinations:
            for datagram in datagrams:
                try:
                    self._sockets[family].sendto(datagram, address)
                except OSError as error:
                    self._log_once(address, error)

    def close(self) -> None:
        """Close the sockets."""
        for each in self._sockets.values():
            each.close()

    def _log_once(self, address: tuple[str, int], error: OSError) -> None:
        if address not in self._refused:
            self._refused.add(address)
            log.warning("osc: cannot send to %s:%d (%s); will keep trying", *address[:2], error)


def _resolve(host: str, port: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except OSError as error:
        raise UserError(
            f"osc: the host '{host}' has no address ({error}); check [osc] destinations"
        ) from error
    return family, (str(address[0]), port)
