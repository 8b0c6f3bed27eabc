"""OSC over UDP to fixed destinations, each with its own format and rate."""

from __future__ import annotations

from halo_service.outputs.destination import Destination, Stream
from halo_service.outputs.formats import Format, make_format
from halo_service.outputs.name_resolver import NameResolver
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame
from halo_service.outputs.throttle import Throttle
from halo_service.outputs.udp_sender import UdpSender


class OscOutput:
    """Sends to every destination, without confirmation; equal streams are encoded once."""

    def __init__(self, destinations: list[Destination]) -> None:
        """No host needs to exist: names are looked up while the service runs."""
        senders = [UdpSender(each) for each in destinations]
        streams = dict.fromkeys(each.stream for each in destinations)
        self._channels = [
            _Channel(stream, [each for each in senders if each.destination.stream == stream])
            for stream in streams
        ]
        self._senders = senders
        self._resolver = NameResolver(senders)

    def send(self, outgoing: Outgoing) -> None:
        """Send to all destinations that receive this surface."""
        for channel in self._channels:
            channel.send(outgoing)

    def close(self) -> None:
        """Close the sockets."""
        self._resolver.close()
        for sender in self._senders:
            sender.close()


class _Channel:
    """The destinations of one stream."""

    def __init__(self, stream: Stream, senders: list[UdpSender]) -> None:
        self._stream = stream
        self._senders = senders
        self._format: Format = make_format(stream)
        self._throttle = Throttle(stream.rate_hz) if stream.rate_hz else None

    def send(self, outgoing: Outgoing) -> None:
        if self._stream.surface not in ("", outgoing.surface):
            return
        datagrams = self._encoded(outgoing)
        for sender in self._senders:
            sender.send(datagrams)

    def _encoded(self, outgoing: Outgoing) -> list[bytes]:
        if not isinstance(outgoing, OutgoingFrame):
            return self._format.report(outgoing)
        frame = self._throttle.take(outgoing) if self._throttle else outgoing
        return [] if frame is None else self._format.frame(frame)
