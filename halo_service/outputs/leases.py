"""Clients that ask for the stream on the control port: hello, welcome, lease, goodbye.

Rule: no I/O and no clock. A stream starts only after the client has sent back the token of its
welcome, so a forged sender address gets one small answer, never a stream; hosts outside the
allowed networks get no answer at all. Everything is bounded.
"""

from __future__ import annotations

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
from halo_service.outputs.networks import Networks

LEASE_S = 10.0
"""A stream ends so long after its client last said hello; clients do so every 3 s."""
MOST_LEASES = 64
MOST_WELCOMES = 256
"""Welcomes that wait for their token; the oldest is dropped."""
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
        self.node, self.session = node, session
        self.networks = Networks(networks)
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
        if not self.networks.allow(message.sender[0]):
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
        """End the streams of clients that have not said hello again."""
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
        host, sent_from = message.sender
        place = f"[{host}]" if ":" in host else host
        outcome, reason, destination = judge(version, f"{place}:{port or sent_from}/{stream}")
        token = ""
        if destination is not None:
            token = self._new_token()
            self._welcomed[token] = destination
            while len(self._welcomed) > MOST_WELCOMES:
                del self._welcomed[next(iter(self._welcomed))]
        answer = welcome(self.node, self.session, outcome, reason, token, LEASE_S)
        return [Reply(answer, message.sender)]

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


def judge(version: str, destination: str) -> tuple[str, str, Destination | None]:
    """Return the outcome of a hello, the reason of a refusal, and what to send where."""
    try:
        outcome = wire.verdict(wire.VERSION, version)
        parsed = parse_destination(destination, "hello")
    except (wire.ProtocolError, UserError) as error:
        return "refused", str(error).encode("ascii", "replace").decode(), None
    if outcome == "refused":
        return outcome, f"this service speaks {wire.VERSION}", None
    return outcome, "", parsed


def welcome(
    node: str, session: str, outcome: str, reason: str, token: str = "", lease_s: float = 0.0
) -> bytes:
    """Return the answer to a hello. Where no lease is needed, it has no `token` and `lease_s`."""
    names = (node, session, wire.VERSION, outcome, token, reason[:LONGEST_REASON])
    return Template(WELCOME, "i", *names).pack(round(lease_s * 1000))[4:]
