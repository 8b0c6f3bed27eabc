"""The ports of this machine: free, used by a service of ours, or by another program."""

from __future__ import annotations

import socket
from collections.abc import Sequence

from halo_service.app.doctor import Finding
from halo_service.app.network.interfaces import Card, firewall_hint
from halo_service.app.network.reach import ENDPOINT
from halo_service.outputs.settings import LISTEN, ZenohSettings

LOCAL = ("127.", "localhost", "[::1]")


def zenoh_ports(settings: ZenohSettings, cards: Sequence[Card], *, answers: bool) -> list[Finding]:
    """Check where a service of these settings listens. `answers`: Zenoh answers there now."""
    endpoints = settings.listen or (() if settings.config else LISTEN)
    return [_port(each, settings, cards, answers=answers) for each in endpoints]


def _port(
    endpoint: str, settings: ZenohSettings, cards: Sequence[Card], *, answers: bool
) -> Finding:
    what = f"port {endpoint}"
    parts = ENDPOINT.match(endpoint)
    if parts is None:
        return Finding(what, False, "is no address", "write it as tcp/0.0.0.0:7447")
    host, port = parts[2].strip("[]"), int(parts[3])
    protocol = "udp" if parts[1] in ("udp", "quic") else "tcp"
    if not answers and (why := _in_use(host, port, protocol)):
        remedy = "set [zenoh] listen" if settings.listen else "a service uses the next free port"
        return Finding(
            what,
            False,
            f"cannot be used ({why})",
            f"another program has it; {remedy}",
            optional=not settings.listen,
        )
    state = "a service or router of Zenoh listens here" if answers else "is free"
    if not parts[2].startswith(LOCAL):
        hint = firewall_hint(port, protocol)
        return Finding(what, not hint, state, hint, optional=True)
    alone = not settings.connect and any(not each.is_loopback for each in cards)
    return Finding(
        what,
        not alone,
        f"{state}, for programs of this machine only",
        'to be reached from other machines: [zenoh] listen = ["tcp/0.0.0.0:7447"], or connect to '
        "a router (docs/networks.md)",
        optional=True,
    )


def _in_use(host: str, port: int, protocol: str) -> str:
    """Return why the port cannot be bound; empty if it can."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    kind = socket.SOCK_DGRAM if protocol == "udp" else socket.SOCK_STREAM
    with socket.socket(family, kind) as probe:
        if kind == socket.SOCK_STREAM:  # as servers do: a closed connection does not count
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            return error.strerror or str(error)
    return ""
