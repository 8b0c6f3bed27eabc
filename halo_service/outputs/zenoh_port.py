"""Opens the Zenoh session of a service: where the user named no port, at the first free one.

A service at another port than the first also connects to the first one. So programs that connect
to the usual port receive all services of the machine: a peer passes on to its clients what other
peers publish.
"""

from __future__ import annotations

import logging
import re
import socket
from dataclasses import replace

import zenoh

from halo_service.errors import UserError
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh_session import Connections, open_session

log = logging.getLogger(__name__)

LOCAL, PORTS = "127.0.0.1", range(7447, 7467)
HERE = re.compile(r"tcp/(?:127\.0\.0\.1|localhost|\[::1\]):(\d+)")


def open_service(settings: ZenohSettings) -> tuple[zenoh.Session, Connections, ZenohSettings]:
    """Open a peer; return it, its connections, and the settings with the port that it uses.

    A port where a service of this machine is expected stays free for it: it may start later.
    Raises `UserError`, also where the user named a port that is in use.
    """
    if settings.listen or settings.config:
        return *open_session(settings, "peer"), settings
    expected = {int(each[1]) for each in map(HERE.match, settings.connect) if each}
    for port in PORTS:
        if port in expected or not _is_free(port):
            continue
        used = replace(settings, listen=(_endpoint(port),))
        is_second = port != PORTS[0] not in expected
        first = (_endpoint(PORTS[0]),) if is_second and not settings.connect else ()
        try:
            opened = open_session(used, "peer", also=first)
        except UserError:
            if _is_free(port):
                raise
            continue  # another service was faster
        if is_second:
            log.warning("zenoh: port %d is in use, so this service uses %d", PORTS[0], port)
        return *opened, used
    raise UserError(
        f"zenoh: ports {PORTS[0]} to {PORTS[-1]} are in use; set [zenoh] listen, or start with "
        "--no-zenoh"
    )


def _endpoint(port: int) -> str:
    return f"tcp/{LOCAL}:{port}"


def _is_free(port: int) -> bool:
    """Whether a TCP port of this machine can be opened."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOCAL, port))
        except OSError:
            return False
        return True
