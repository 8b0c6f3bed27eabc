"""Whether Zenoh's multicast finds a router or service, on each network card."""

from __future__ import annotations

import json
from collections.abc import Sequence

import zenoh

from halo_service.app.doctor import Finding
from halo_service.app.network.interfaces import Card
from halo_service.outputs.zenoh_session import reason

REMEDY = (
    "services answer only with [zenoh] multicast = true, and many networks block it: name the "
    "address with --connect"
)


class Scouts:
    """Asks on all network cards at once, from the start until `findings`."""

    def __init__(self, cards: Sequence[Card]) -> None:
        self._scouts: list[tuple[Card, zenoh.Scout[zenoh.handlers.Handler[zenoh.Hello]]]] = []
        self._faults: list[Finding] = []
        for card in cards:
            config = zenoh.Config()
            config.insert_json5("scouting/multicast/interface", json.dumps(card.name))
            try:
                self._scouts.append((card, zenoh.scout(what="peer|router", config=config)))
            except zenoh.ZError as error:
                state = f"cannot be used ({reason(error)})"
                self._faults.append(Finding(_what(card), False, state, REMEDY, optional=True))

    def findings(self) -> list[Finding]:
        """End the search; return a finding for each card."""
        return [*self._faults, *(_finding(card, scout) for card, scout in self._scouts)]


def _finding(card: Card, scout: zenoh.Scout[zenoh.handlers.Handler[zenoh.Hello]]) -> Finding:
    places = set()
    while (hello := scout.try_recv()) is not None:
        places.add(f"{hello.whatami} at {', '.join(hello.locators[:2]) or 'no address'}")
    scout.stop()
    if not places:
        return Finding(_what(card), False, "no answer", REMEDY, optional=True)
    return Finding(_what(card), True, f"works: {'; '.join(sorted(places)[:5])}")


def _what(card: Card) -> str:
    return f"multicast on {card.name}"
