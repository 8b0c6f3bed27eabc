"""Runs the bridge: one lane for each node, a port for clients that ask, a server for browsers."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from contextlib import ExitStack

import halo_protocol as wire
from halo_client import Follow, ZenohSource
from halo_service.app.bridge.lane import Lane
from halo_service.app.bridge.relay import Relay
from halo_service.app.following import opened
from halo_service.app.service.client_ports import ClientPorts
from halo_service.settings import Settings

log = logging.getLogger(__name__)

STATUS_S = 10.0
"""How often new losses are logged."""


def bridge(settings: Settings, follows: Sequence[Follow], source: ZenohSource) -> None:
    """Serve nodes on the outputs of the settings until Ctrl-C or SIGTERM.

    `follows`: one or more; with several, their surfaces are called NODE-SURFACE. `source`: the
    network. Raises `UserError`.
    """
    node = follows[0].node if follows[0].node != wire.ANY else settings.node
    with ExitStack() as stack:
        ports = ClientPorts(settings, node, stack)
        lanes = []
        for follow in follows:
            relay = Relay(settings.osc.max_bytes, with_node=len(follows) > 1)
            received = opened(source, follow, "bridge")
            lanes.append(Lane(received, follow, relay, ports.destinations, ports.carriers))
            stack.callback(lanes[-1].close)
        network = ", ".join(source.connect) or source.config
        log.info("zenoh from %s: %s", network, ", ".join(lane.name for lane in lanes))
        ports.log()
        log.info("ready; Ctrl-C ends")
        reported = {lane: lane.losses for lane in lanes}
        next_s = time.monotonic() + STATUS_S
        for leased in ports.turns():
            for lane in lanes:
                lane.leased = leased
            if time.monotonic() >= next_s:
                next_s = time.monotonic() + STATUS_S
                _report(lanes, reported)


def _report(lanes: Sequence[Lane], reported: dict[Lane, str]) -> None:
    """Log each lane that lost something since it was reported last."""
    for lane in lanes:
        losses = lane.losses
        if reported[lane] != losses:
            reported[lane] = losses
            log.info("%s", lane.status)
