"""Runs the bridge: one lane for each node, a port for clients that ask, a server for browsers."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace

import halo_protocol as wire
from halo_client import ClientError, Follow, ZenohSource
from halo_client.zenoh_input import ZenohInput
from halo_service.app.bridge.lane import Lane
from halo_service.app.bridge.relay import Relay
from halo_service.app.process import stop_on_signals
from halo_service.app.service.carriers import answer_hellos, destinations, web_server
from halo_service.errors import UserError
from halo_service.outputs.control import ControlPort
from halo_service.outputs.leases import Leases
from halo_service.outputs.name_watch import NameWatch
from halo_service.settings import Settings

log = logging.getLogger(__name__)

TURN_S = 0.05
"""How often clients that ask for the stream are answered."""
STATUS_S = 10.0
"""How often new losses are logged."""


def bridge(settings: Settings, follows: Sequence[Follow], source: ZenohSource) -> None:
    """Serve nodes on the outputs of the settings until Ctrl-C or SIGTERM.

    `follows`: one or more; with several, their surfaces are called NODE-SURFACE. `source`: the
    network. Raises `UserError`.
    """
    wanted = destinations(settings)  # a wrong one ends the command before anything is opened
    node = follows[0].node if follows[0].node != wire.ANY else settings.node
    session = f"s{secrets.token_hex(4)}"
    stopped = threading.Event()
    stop_on_signals(stopped.set)
    with ExitStack() as stack:
        control = ControlPort(settings.control.host, settings.control.port)
        stack.callback(control.close)
        web = web_server(settings, NameWatch(node, session), control, stack)
        lanes = []
        for follow in follows:
            relay = Relay(settings.osc.max_bytes, with_node=len(follows) > 1)
            lanes.append(Lane(_opened(source, follow), follow, relay, wanted, [web] if web else []))
            stack.callback(lanes[-1].close)
        network = ", ".join(source.connect) or source.config
        log.info("zenoh from %s: %s", network, ", ".join(lane.name for lane in lanes))
        log.info("osc to %s", ", ".join(map(str, wanted)) or "off")
        log.info("browsers: %s; control port %d", web.url if web else "off", control.port)
        log.info("ready; Ctrl-C ends")
        leases = Leases(node, session, settings.control.networks)
        reported = {lane: lane.losses for lane in lanes}
        next_s = time.monotonic() + STATUS_S
        while not stopped.wait(TURN_S):
            leased = answer_hellos(control, leases)
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


def _opened(source: ZenohSource, follow: Follow) -> ZenohInput:
    try:
        return ZenohInput(replace(source, follow=follow))
    except ClientError as error:
        raise UserError(f"bridge: {error}") from error
