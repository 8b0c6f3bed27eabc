"""One node of the bridge: a thread that receives from Zenoh and sends on all outputs.

Each has its own OSC senders, because rates and TUIO's numbers are counted for one stream.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence

from halo_client import Follow, Input, Receiver, Silence
from halo_client.errors import EndOfStream
from halo_client.receiver import NodeWatch
from halo_protocol import ANY
from halo_service.app.bridge.relay import Relay
from halo_service.outputs import Carrier
from halo_service.outputs.destination import Destination
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import Reported
from halo_service.runtime.error_log import ErrorLog

log = logging.getLogger(__name__)

TICK_S = 0.1
"""How often lost nodes, new clients and the end are noticed while nothing arrives."""


class Lane:
    """Follows one surface of one node until it is closed."""

    def __init__(
        self,
        source: Input,
        follow: Follow,
        relay: Relay,
        destinations: Sequence[Destination],
        carriers: Sequence[Carrier],
    ) -> None:
        """Start. `destinations`: of OSC and TUIO; `carriers`: are shared by all lanes."""
        self._relay = relay
        self._input = _Tap(source, relay.read)
        self._receiver = Receiver(self._input, follow)
        self._osc = OscOutput(list(destinations))
        self._carriers = [self._osc, *carriers]
        self._errors = ErrorLog()
        named = [each for each in (follow.node, follow.surface) if each != ANY]
        self.name = "/".join(named) or "any node"
        """Of node and surface, as far as it is clear which they are."""
        self._welcomed: list[Destination] = []
        self.leased: list[Destination] = []
        """Clients that asked for the stream; replaced as a whole by another thread."""
        self._thread = threading.Thread(target=self._run, name=f"bridge {self.name}", daemon=True)
        self._thread.start()

    @property
    def losses(self) -> str:
        """What was lost so far, as part of a sentence."""
        losses = self._receiver.losses
        return (
            f"{self._relay.missed} frames missed, {losses.incomplete} incomplete, "
            f"{losses.dropped} late or twice, {losses.bad} bad datagrams"
        )

    @property
    def status(self) -> str:
        """What arrived and what was lost so far, as a sentence."""
        return f"{self.name}: {self._relay.frames} frames arrived, {self.losses}"

    def close(self) -> None:
        """Send a last frame without pointers, and close."""
        self._input.ended.set()
        self._thread.join()
        self._receiver.close()
        self._osc.close()
        log.info("%s", self.status)

    def _run(self) -> None:
        silence = Silence(f"{self._receiver.url} of {self.name}", time.monotonic())
        while not self._receiver.ended:
            with self._errors.guard(f"bridge {self.name}"):
                self._welcome()
                events = self._receiver.poll(TICK_S)
                for outgoing in self._relay.outgoing(events, self._receiver.services.scenes):
                    for carrier in self._carriers:
                        carrier.send(outgoing)
                if self._receiver.following is not None:
                    self.name = "/".join(self._receiver.following[:2])
                said = silence.notice(events, time.monotonic())
                if said and not self._receiver.ended:
                    log.info("%s", said)

    def _welcome(self) -> None:
        """Send to those that asked for the stream; new ones get the latest reports at once."""
        before, self._welcomed = self._welcomed, self.leased
        self._osc.set_leased(self._welcomed)
        if all(each in before for each in self._welcomed):
            return
        known, following = self._receiver.services, self._receiver.following
        reports: list[tuple[tuple[str, str], Reported]] = [
            *known.scenes.items(),
            *known.homographies.items(),
            *known.poses.items(),
        ]
        for where, message in reports:
            if following is None or where == following[:2]:
                self._osc.send(self._relay.report(where[1], message))


class _Tap:
    """An input. Each datagram is read before the receiver has it; `ended` ends it for good."""

    def __init__(self, source: Input, read: Callable[[bytes], None]) -> None:
        self._source = source
        self._read = read
        self.url = source.url
        self.ended = threading.Event()

    @property
    def left(self) -> frozenset[str]:
        """As of the source; none where it does not know."""
        return self._source.left if isinstance(self._source, NodeWatch) else frozenset()

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        if self.ended.is_set():
            raise EndOfStream
        received = self._source.receive(timeout_s)
        if received is not None:
            self._read(received[0])
        return received

    def close(self) -> None:
        self._source.close()
