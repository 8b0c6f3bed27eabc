"""Output of touch frames: OSC, Zenoh, files.

Rule: a frame is encoded once, in `frame_encoder`; every carrier sends the same bytes.
"""

from __future__ import annotations

from typing import Protocol


class Carrier(Protocol):
    """Sends datagrams. It never blocks and never raises because of a receiver."""

    def send(self, kind: str, datagrams: list[bytes]) -> None:
        """Send the datagrams of one message or frame. `kind`: last part of the Zenoh key."""

    def close(self) -> None:
        """Close sockets and sessions."""
