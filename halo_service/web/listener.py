"""Opens the TCP port of a server, and limits its connections."""

from __future__ import annotations

import asyncio
import errno
import logging
import socket

from aiohttp import web

from halo_service.errors import UserError

log = logging.getLogger(__name__)

MAX_CONNECTIONS = 256
"""Open connections of any kind; more could use up the service's file descriptors."""


class ConnectionLimit(asyncio.Protocol):
    """A new connection: passed to the server, or closed if there are too many."""

    def __init__(self, server: web.Server) -> None:
        self._server = server

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Pass it on or close it."""
        if len(self._server.connections) >= MAX_CONNECTIONS:
            transport.close()
            return
        handler = self._server()
        transport.set_protocol(handler)
        handler.connection_made(transport)


def listening(section: str, host: str, port: int) -> socket.socket:
    """Open a port, or a free one where it is in use.

    `section`: of the settings that name host and port. Raises `UserError` for a host that is not
    an address of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        try:
            return socket.create_server((host, port), family=family)
        except OSError as error:
            if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                raise
            listener = socket.create_server((host, 0), family=family)
    except OSError as error:
        raise UserError(
            f"{section}: port {port} on {host} cannot be opened ({error.strerror}); "
            f"set [{section}] host to an address of this machine, such as 127.0.0.1, or use "
            f"--no-{section}"
        ) from error
    used = listener.getsockname()[1]
    log.warning("%s: port %d is in use, so this service uses %d", section, port, used)
    return listener


def bracketed(host: str) -> str:
    """Return a host as it is written in a URL."""
    return f"[{host}]" if ":" in host else host
