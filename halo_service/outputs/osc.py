"""OSC over UDP to fixed destinations, each with its own format and rate."""

from __future__ import annotations

from halo_service.outputs.destination import Destination, Stream
from halo_service.outputs.name_resolver import NameResolver
from halo_service.outputs.outgoing import Outgoing
from halo_service.outputs.stream_encoder import StreamEncoder
from halo_service.outputs.udp_sender import UdpSender


class OscOutput:
    """Sends to every destination, without confirmation; equal streams are encoded once."""

    def __init__(self, destinations: list[Destination]) -> None:
        """No host needs to exist: names are looked up while the service runs."""
        self._channels: dict[Stream, _Channel] = {}
        self._leased: dict[Destination, UdpSender] = {}
        self._senders: list[UdpSender] = []
        self._resolver = NameResolver(self._senders)
        self.set_fixed(destinations)

    def send(self, outgoing: Outgoing) -> None:
        """Send to all destinations that receive this surface."""
        for channel in self._channels.values():
            channel.send(outgoing)

    @property
    def senders(self) -> list[UdpSender]:
        """All that sends now, for counts; from any thread."""
        return [*self._senders, *self._leased.values()]

    def set_fixed(self, destinations: list[Destination]) -> None:
        """Send to these from now on, besides those that come and go."""
        for gone in [each for each in self._senders if each.destination not in destinations]:
            self._senders.remove(gone)
            self._remove(gone)
        known = [each.destination for each in self._senders]
        self._senders += [self._add(each) for each in destinations if each not in known]
        self._resolver.close()
        self._resolver = NameResolver(self._senders)

    def set_leased(self, destinations: list[Destination]) -> None:
        """Set the destinations that come and go; their hosts are addresses, not names."""
        if destinations == list(self._leased):
            return
        for gone in [each for each in self._leased if each not in destinations]:
            self._remove(self._leased.pop(gone))
        for each in destinations:
            if each not in self._leased:
                self._leased[each] = self._add(each)

    def close(self) -> None:
        """Close the sockets."""
        self._resolver.close()
        for sender in (*self._senders, *self._leased.values()):
            sender.close()

    def _add(self, destination: Destination) -> UdpSender:
        sender = UdpSender(destination)
        stream = destination.stream
        if stream not in self._channels:
            self._channels[stream] = _Channel(stream)
        self._channels[stream].senders.append(sender)
        return sender

    def _remove(self, sender: UdpSender) -> None:
        stream = sender.destination.stream
        self._channels[stream].senders.remove(sender)
        if not self._channels[stream].senders:
            del self._channels[stream]
        sender.close()


class _Channel:
    """The destinations of one stream."""

    def __init__(self, stream: Stream) -> None:
        self._encoder = StreamEncoder(stream)
        self.senders: list[UdpSender] = []

    def send(self, outgoing: Outgoing) -> None:
        datagrams = self._encoder.datagrams(outgoing)
        for sender in self.senders:
            sender.send(datagrams)
