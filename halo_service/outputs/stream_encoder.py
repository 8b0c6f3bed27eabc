"""Encodes one stream: its surface, its rate and its format."""

from __future__ import annotations

from halo_service.outputs.destination import Stream
from halo_service.outputs.formats import Format, make_format
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame
from halo_service.outputs.throttle import Throttle


class StreamEncoder:
    """Remembers what the rate and the format need, nothing else."""

    def __init__(self, stream: Stream) -> None:
        """Start a stream; its first frame is sent."""
        self._stream = stream
        self._format: Format = make_format(stream)
        self._throttle = Throttle(stream.rate_hz) if stream.rate_hz else None

    def chosen(self, outgoing: Outgoing) -> Outgoing | None:
        """Return what to send instead; None for another surface, or a frame that is not due."""
        if self._stream.surface not in ("", outgoing.surface):
            return None
        if outgoing.named_only and not self._stream.surface:
            return None
        if self._throttle is None or not isinstance(outgoing, OutgoingFrame):
            return outgoing
        return self._throttle.take(outgoing)

    def datagrams(self, outgoing: Outgoing) -> list[bytes]:
        """Return the datagrams of a frame or report, in the stream's format."""
        chosen = self.chosen(outgoing)
        if chosen is None:
            return []
        if isinstance(chosen, OutgoingFrame):
            return self._format.frame(chosen)
        return self._format.report(chosen)
