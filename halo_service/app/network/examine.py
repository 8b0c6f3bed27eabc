"""`halo doctor --network`: explains what this machine can reach, and what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from halo_client import ZenohSource
from halo_service.app.doctor import Finding, control_port
from halo_service.app.fleet.watch import sources
from halo_service.app.network import nodes, ports
from halo_service.app.network.interfaces import Card, cards
from halo_service.app.network.multicast import Scouts
from halo_service.app.network.reach import reach
from halo_service.outputs.settings import ZenohSettings
from halo_service.settings import Settings

SECONDS = 3.5
"""How long frames and reports are received: health comes once a second."""


def examine_network(settings: Settings, connect: Sequence[str] = ()) -> list[Finding]:
    """Look for some seconds. `connect`: routers or services, instead of those of the settings."""
    here = cards()
    scouts = Scouts(here)
    local = sources(ZenohSettings(listen=settings.zenoh.listen))
    named = _named(settings.zenoh, connect)
    places = list(dict.fromkeys((*named, *local)))
    with ThreadPoolExecutor(len(places)) as pool:
        reached = dict(zip(places, pool.map(lambda each: reach(each, here), places), strict=True))
    received = nodes.receive([each for each in places if reached[each][1]], SECONDS)
    # That no service runs on this machine is no fault.
    shown = [each for each in places if each in named or reached[each][1]]
    return [
        _networks(here),
        *ports.zenoh_ports(settings.zenoh, here, answers=any(reached[each][1] for each in local)),
        replace(control_port(settings), optional=True),  # a free one is used instead
        *(finding for each in shown for finding in reached[each][0]),
        *scouts.findings(),
        *nodes.findings(received),
        *_none_found(received, [each for each in named if reached[each][1]], named),
    ]


def _named(settings: ZenohSettings, connect: Sequence[str]) -> list[ZenohSource]:
    """Return the routers and services that the user names, on the line or in the settings."""
    if not (connect or settings.connect or settings.config or settings.multicast):
        return []
    outside = ZenohSettings(
        connect=settings.connect, multicast=settings.multicast, config=settings.config
    )
    local = sources(ZenohSettings())
    return [each for each in sources(outside, connect) if connect or each not in local]


def _networks(here: Sequence[Card]) -> Finding:
    state = "; ".join(map(str, here)) or "none"
    alone = all(each.is_loopback for each in here)
    remedy = "no other machine can be reached: plug in a cable or join the Wi-Fi"
    return Finding("networks", not alone, state, remedy, optional=True)


def _none_found(
    received: nodes.Received, answering: Sequence[ZenohSource], named: Sequence[ZenohSource]
) -> list[Finding]:
    """Return a finding if no node was found; a fault where a router or service answers."""
    if received.nodes or (named and not answering):
        return []  # that nothing answers is a finding already
    remedy = (
        "start 'halo serve' there, with [zenoh] connect if this is a router; a router's access "
        "control may also hide nodes from this machine"
        if named
        else "start 'halo serve', or name a router or service with --connect tcp/HOST:7447"
    )
    return [Finding("nodes", False, "none found", remedy, optional=not named)]
