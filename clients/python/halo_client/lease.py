"""Asks a service for its stream, and asks again before the lease ends.

Rule: pure. Datagrams and times are arguments; a socket sends what `due` returns.
"""

from __future__ import annotations

import logging

from halo_client.errors import ClientError
from halo_protocol import ProtocolError, parse_osc
from halo_protocol.handshake import (
    CONTROL,
    EXPIRED,
    GOODBYE,
    LEASE,
    WELCOME,
    hello,
    with_token,
)

_LOG = logging.getLogger("halo_client")
HELLO_S = 1.0
"""Pause between two hellos: a service that starts later is found within a second."""
LEASE_S = 3.0
"""Pause between two leases; a service ends a stream after 10 s without one."""
_CONTROL = CONTROL.encode()


class Lease:
    """The stream of one service."""

    def __init__(self, stream: str, service: str) -> None:
        """`stream`: such as `frames,rate=30`. `service`: its control port, for messages."""
        self._hello = hello(stream)
        self._service = service
        self._token = ""
        self._next_s = float("-inf")
        self._warned = False

    def due(self, now_s: float) -> bytes | None:
        """The hello or lease to send now, if it is time."""
        if now_s < self._next_s:
            return None
        self._next_s = now_s + (LEASE_S if self._token else HELLO_S)
        return with_token(LEASE, self._token) if self._token else self._hello

    def wait_s(self, now_s: float) -> float:
        """Seconds until something is due."""
        return max(0.0, self._next_s - now_s)

    def goodbye(self) -> bytes | None:
        """The message that ends the stream, if there is one."""
        return with_token(GOODBYE, self._token) if self._token else None

    def handle(self, datagram: bytes) -> bool:
        """Whether the datagram is an answer of the control port; it is processed then.

        `ClientError` if the service refuses.
        """
        if not datagram.startswith(_CONTROL):
            return False
        try:
            ((address, arguments),) = parse_osc(datagram)
        except (ProtocolError, ValueError):
            return True
        match address, arguments:
            case str(), (str(), str(), str(), str() as outcome, str() as token, str() as why, *_):
                if address == WELCOME:
                    self._welcomed(outcome, token, why)
            case str(), (str() as token, *_) if address == EXPIRED and token == self._token:
                self._renew("")
        return True

    def _welcomed(self, outcome: str, token: str, reason: str) -> None:
        if outcome == "refused":
            raise ClientError(f"the service at {self._service} refuses: {reason}")
        if outcome == "warned" and not self._warned:
            self._warned = True
            _LOG.warning(
                "the service at %s has a newer protocol than this program: it sends more than "
                "this program reads; update halo_client",
                self._service,
            )
        if not self._token:
            self._renew(token)

    def _renew(self, token: str) -> None:
        """Use a token; without one, say hello again."""
        self._token = token
        self._next_s = float("-inf")
