"""Output of touch frames: OSC, Zenoh, files.

Rule: a frame is converted once, in `frame_encoder`; every carrier sends the same messages.
"""

from __future__ import annotations

from typing import Protocol

from halo_service.outputs.outgoing import Outgoing


class Carrier(Protocol):
    """Sends frames and reports. It never blocks and never raises because of a receiver."""

    def send(self, outgoing: Outgoing) -> None:
        """Send one."""

    def close(self) -> None:
        """Close sockets and sessions."""
