"""Where touches go: OSC, Zenoh, files.

Rule: the wire's bytes are made once, in `wire`, and every carrier sends the same.
"""

from __future__ import annotations

from typing import Protocol


class Carrier(Protocol):
    """Takes datagrams somewhere. Never blocks, never raises for a receiver's sake."""

    def send(self, kind: str, datagrams: list[bytes]) -> None:
        """Send the datagrams of one message or frame. `kind`: the Zenoh key's last part."""

    def close(self) -> None:
        """Let go of sockets and sessions."""
