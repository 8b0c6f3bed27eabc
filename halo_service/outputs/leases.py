"""Clients that ask for the stream on the control port: hello, welcome, lease, goodbye.

Rule: no I/O and no clock. A stream starts only after the client has sent back the token of its
welcome, so a forged sender address gets one small answer, never a stream; hosts outside the
allowed networks get no answer at all. Everything is bounded.
"""

from __future__ import annotations

import ipaddress
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import halo_protocol as wire
from halo_protocol.handshake import (
    EXPIRED,
    GOODBYE,
    HELLO,
    LEAST_HELLO,
    WELCOME,
    with_token,
)
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage
from halo_service.outputs.destination import Destination, parse_destination
from halo_service.outputs.formats.packing import Template

LEASE_S = 10.0
"""A stream ends so long after its client last asked; clients ask every 3 s."""
MOST_LEASES = 64
MOST_WELCOMES = 256
"""Welcomes whose token may still come back; the oldest is dropped."""
LONGEST_REASON = 80


class Reply(NamedTuple):
    """A datagram to send from the control port."""

    datagram: bytes
    to: tuple[str, int]


@dataclass(slots=True)
class _Lease:
    destination: Destination
    until_s: float


class Leases:
    """The clients of one service."""

    def __init__(
        self,
        node: str,
        session: str,
        networks: Sequence[str],
        new_token: Callable[[], str] = lambda: f"t{secrets.token_hex(8)}",
    ) -> None:
        """`networks`: such as 127.0.0.0/8; only hosts in them are answered.

        Raises `UserError` for a network that cannot be read.
        """
        self._node, self._session = node, session
        self._networks = [_network(each) for each in networks]
        self._new_token = new_token
        self._welcomed: dict[str, Destination] = {}
        self._leases: dict[str, _Lease] = {}
        self.refused = 0
        """Messages of hosts outside the networks, and hellos that are too short."""

    @property
    def destinations(self) -> list[Destination]:
        """Where streams go now."""
        return [lease.destination for lease in self._leases.values()]

    def handle(self, message: ControlMessage, now_s: float) -> list[Reply]:
        """Handle a hello, lease or goodbye; the replies go to its sender."""
        if not self._allowed(message.sender[0]):
            self.refused += 1
            return []
        if message.address == HELLO:
            return self._hello(message)
        token = message.arguments[0] if message.arguments else None
        if not isinstance(token, str):
            self.refused += 1
            return []
        if message.address == GOODBYE:
            self._goodbye(token, message.sender[0])
            return []
        return self._lease(token, message.sender, now_s)

    def expire(self, now_s: float) -> None:
        """End the streams of clients that have not asked again."""
        for token in [each for each, lease in self._leases.items() if now_s > lease.until_s]:
            del self._leases[token]

    def _hello(self, message: ControlMessage) -> list[Reply]:
        match message.arguments:
            case (str() as version, str() as stream, int() as port, *_) if (
                message.size >= LEAST_HELLO and 0 <= port < 65536
            ):
                pass
            case _:
                self.refused += 1
                return []
        outcome, reason, destination = self._judged(version, stream, message.sender, port)
        token = ""
        if destination is not None:
            token = self._new_token()
            self._welcomed[token] = destination
            while len(self._welcomed) > MOST_WELCOMES:
                del self._welcomed[next(iter(self._welcomed))]
        names = (self._node, self._session, wire.VERSION, outcome, token)
        welcome = Template(WELCOME, "i", *names, reason[:LONGEST_REASON])
        return [Reply(welcome.pack(round(LEASE_S * 1000))[4:], message.sender)]

    def _judged(
        self, version: str, stream: str, sender: tuple[str, int], port: int
    ) -> tuple[str, str, Destination | None]:
        host = f"[{sender[0]}]" if ":" in sender[0] else sender[0]
        try:
            outcome = wire.verdict(wire.VERSION, version)
            destination = parse_destination(f"{host}:{port or sender[1]}/{stream}", "hello")
        except (wire.ProtocolError, UserError) as error:
            return "refused", str(error).encode("ascii", "replace").decode(), None
        if outcome == "refused":
            return outcome, f"this service speaks {wire.VERSION}", None
        return outcome, "", destination

    def _lease(self, token: str, sender: tuple[str, int], now_s: float) -> list[Reply]:
        lease = self._leases.get(token)
        known = lease.destination if lease else self._welcomed.get(token)
        full = lease is None and len(self._leases) >= MOST_LEASES
        if known is None or known.host != sender[0] or full:
            return [Reply(with_token(EXPIRED, token[:32]), sender)]
        self._welcomed.pop(token, None)
        self._leases[token] = _Lease(known, now_s + LEASE_S)
        return []

    def _goodbye(self, token: str, host: str) -> None:
        lease = self._leases.get(token)
        if lease is not None and lease.destination.host == host:
            del self._leases[token]

    def _allowed(self, host: str) -> bool:
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
