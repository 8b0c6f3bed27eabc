"""Datagrams from a UDP port.

Rule: only the socket. The port is never shared: with SO_REUSEPORT one of two clients would
silently get nothing, or each would get a part.
"""

from __future__ import annotations

import contextlib
import errno
import socket
import time
from typing import Self

from halo_client.errors import ClientError
from halo_client.lease import Lease
from halo_client.source import OscSource
from halo_protocol import DEFAULT_CONTROL_PORT

_LARGEST = 65_535
_BUFFER_BYTES = 1 << 20
"""The kernel buffers some seconds of frames for a busy client, then drops."""


class UdpInput:
    """An open port. A context manager; `ClientError` if it cannot be opened."""

    def __init__(self, source: OscSource) -> None:
        self._service = _resolved(source.hello) if source.hello else None
        host = source.host or _address_towards(self._service)
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
            self._socket.bind((host, source.port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise ClientError(_cannot_bind(source, error)) from error
        self.url = f"osc://{_bracketed(host)}:{self._socket.getsockname()[1]}"
        """Its address, with the port that the system chose."""
        self._lease: Lease | None = None
        if self._service and source.hello:
            service = f"{_bracketed(source.hello[0])}:{source.hello[1]}"
            self._lease = Lease(source.stream, service)
            self.url += f"?hello={service}"

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next datagram and its sender, or None after the timeout.

        `ClientError` if the service refuses the requested stream.
        """
        if self._lease:
            self._send(self._lease.due(time.monotonic()))
            timeout_s = min(timeout_s, self._lease.wait_s(time.monotonic()))
        # A timeout of 0 would mean "non-blocking", which raises another error.
        self._socket.settimeout(max(timeout_s, 1e-4))
        try:
            datagram, address = self._socket.recvfrom(_LARGEST)
        except TimeoutError:
            return None
        except ConnectionResetError:
            # Windows: an earlier reply did not reach its receiver. The port still works.
            return None
        if self._lease and address[:2] == self._service and self._lease.handle(datagram):
            return None
        return datagram, str(address[0])

    def _send(self, datagram: bytes | None) -> None:
        if datagram and self._service:
            with contextlib.suppress(OSError):  # The network is down: it is sent again.
                self._socket.sendto(datagram, self._service)

    def close(self) -> None:
        """Close the port; end the requested stream. May be called twice."""
        if self._lease and self._socket.fileno() >= 0:
            self._send(self._lease.goodbye())
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _resolved(place: tuple[str, int]) -> tuple[str, int]:
    """Address and port of a service; IPv4 if it has both."""
    try:
        found = socket.getaddrinfo(*place, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise ClientError(f"osc: no address of {place[0]!r} is found; check the name") from error
    host, port = min(found, key=lambda each: each[0] != socket.AF_INET)[4][:2]
    return str(host), int(port)


def _address_towards(service: tuple[str, int] | None) -> str:
    """The address of this machine that a service sees."""
    if service is None:
        return "127.0.0.1"
    family = socket.AF_INET6 if ":" in service[0] else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(service)  # It sends nothing: the system only chooses a route.
        except OSError as error:
            raise ClientError(f"osc: no network reaches {service[0]} ({error.strerror})") from error
        return str(probe.getsockname()[0])


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _cannot_bind(source: OscSource, error: Exception) -> str:
    where = f"UDP port {source.port} on {source.host}"
    if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
        return (
            f"{where} is in use, probably by another client: close it, or receive from "
            f"'osc://?hello=127.0.0.1:{DEFAULT_CONTROL_PORT}' (with the service's address, if it "
            "is on another machine), which any number of clients can do at once"
        )
    if isinstance(error, OSError) and error.errno == errno.EACCES:
        return f"{where} needs administrator rights; choose a port above 1023"
    return f"cannot listen on {where} ({error}); is {source.host} an address of this machine?"
