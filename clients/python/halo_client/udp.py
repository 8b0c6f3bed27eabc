"""Datagrams from a UDP port.

Rule: only the socket. The port is never shared: with SO_REUSEPORT one of two clients would
silently get nothing, or each would get a part.
"""

from __future__ import annotations

import errno
import socket
from typing import Self

from halo_client.errors import ClientError
from halo_client.source import OscSource

_LARGEST = 65_535
_BUFFER_BYTES = 1 << 20
"""The kernel buffers some seconds of frames for a busy client, then drops."""


class UdpInput:
    """An open port. A context manager; `ClientError` if it cannot be opened."""

    def __init__(self, source: OscSource) -> None:
        family = socket.AF_INET6 if ":" in source.host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
            self._socket.bind((source.host, source.port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise ClientError(_cannot_bind(source, error)) from error
        self.url = f"osc://{_bracketed(source.host)}:{self._socket.getsockname()[1]}"
        """Its address, with the port that the system chose."""

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next datagram and its sender, or None after the timeout."""
        # A timeout of 0 would mean "non-blocking", which raises another error.
        self._socket.settimeout(max(timeout_s, 1e-4))
        try:
            datagram, address = self._socket.recvfrom(_LARGEST)
        except TimeoutError:
            return None
        except ConnectionResetError:
            # Windows: an earlier reply did not reach its receiver. The port still works.
            return None
        return datagram, str(address[0])

    def close(self) -> None:
        """Close the port. May be called twice."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _cannot_bind(source: OscSource, error: Exception) -> str:
    where = f"UDP port {source.port} on {source.host}"
    if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
        return (
            f"{where} is in use, probably by another client: close it, or let the service send "
            f"to one more port and receive there (osc://{_bracketed(source.host)}:"
            f"{source.port + 2}), or use zenoh, which any number of clients can share"
        )
    if isinstance(error, OSError) and error.errno == errno.EACCES:
        return f"{where} needs administrator rights; choose a port above 1023"
    return f"cannot listen on {where} ({error}); is {source.host} an address of this machine?"
