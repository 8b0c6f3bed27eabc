"""Notices another service with this node's name, such as a cloned machine.

Rule: no I/O; whatever receives messages of other services passes them in. The time is an argument.
"""

from __future__ import annotations

import logging
import threading

import halo_protocol as wire

log = logging.getLogger(__name__)

LASTS_S = 5.0
"""A collision is reported for this long after the other service was last received."""


class NameWatch:
    """The name of one service; may be used by any thread."""

    def __init__(self, node: str, session: str) -> None:
        self.node = node
        self.session = session
        self._lock = threading.Lock()
        self._other: str | None = None
        self._seen_s = float("-inf")

    def datagram(self, datagram: bytes, now_s: float) -> None:
        """Look at a datagram of another service; what cannot be decoded is ignored."""
        try:
            messages = wire.decode(datagram)
        except wire.ProtocolError:
            return
        for _, message in messages:
            if isinstance(message, wire.Scene):
                self.seen(message.node, message.session, now_s)

    def seen(self, node: str, session: str, now_s: float) -> bool:
        """Note a service; true if it has our name and is not us. Logged once per session."""
        if node != self.node or session == self.session:
            return False
        with self._lock:
            known, self._other, self._seen_s = self._other == session, session, now_s
        if not known:
            log.warning(
                "node: another running service is also called '%s' (session %s): clients cannot "
                "separate the two; give one of them another name with --node",
                node,
                session[:32],
            )
        return True

    def collision(self, now_s: float) -> bool:
        """Whether another service with our name was received in the last seconds."""
        with self._lock:
            return now_s - self._seen_s < LASTS_S
