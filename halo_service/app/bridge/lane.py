"""One node of the bridge: a thread that receives from Zenoh and sends on all outputs.

Each has its own OSC senders, because rates and TUIO's numbers are counted for one stream.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence

from halo_client import Follow, Input
from halo_protocol import Event
from halo_service.app.bridge.relay import Relay
from halo_service.app.following import Following
from halo_service.outputs import Carrier
from halo_service.outputs.destination import Destination
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import Reported

log = logging.getLogger(__name__)


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
        self._osc = OscOutput(list(destinations))
        self._carriers = [self._osc, *carriers]
        self._welcomed: list[Destination] = []
        self.leased: list[Destination] = []
        """Clients that asked for the stream; replaced as a whole by another thread."""
        self._following = Following(source, follow, self._turn, "bridge", relay.read)
        self._following.start()

    @property
    def name(self) -> str:
        """Of node and surface, as far as it is clear which they are."""
        return self._following.name

    @property
    def losses(self) -> str:
        """What was lost so far, as part of a sentence."""
        return f"{self._relay.missed} frames missed, {self._following.losses}"

    @property
    def status(self) -> str:
        """What arrived and what was lost so far, as a sentence."""
        return f"{self.name}: {self._relay.frames} frames arrived, {self.losses}"

    def close(self) -> None:
        """Send a last frame without pointers, and close."""
        self._following.close()
        self._osc.close()
        log.info("%s", self.status)

    def _turn(self, events: list[Event]) -> None:
        self._welcome()
        for outgoing in self._relay.outgoing(events, self._following.receiver.services.scenes):
            for carrier in self._carriers:
                carrier.send(outgoing)

    def _welcome(self) -> None:
        """Send to those that asked for the stream; new ones get the latest reports at once."""
        before, self._welcomed = self._welcomed, self.leased
        self._osc.set_leased(self._welcomed)
        if all(each in before for each in self._welcomed):
            return
        receiver = self._following.receiver
        known, following = receiver.services, receiver.following
        reports: list[tuple[tuple[str, str], Reported]] = [
            *known.scenes.items(),
            *known.homographies.items(),
            *known.poses.items(),
        ]
        for where, message in reports:
            if following is None or where == following[:2]:
                self._osc.send(self._relay.report(where[1], message))
