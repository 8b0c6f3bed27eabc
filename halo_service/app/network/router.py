"""A Zenoh router: services and clients of several networks meet at it."""

from __future__ import annotations

import json
import logging
import threading
from dataclasses import dataclass

import zenoh

import halo_protocol as wire
from halo_service.app.process import stop_on_signals
from halo_service.errors import UserError
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh_session import open_session

log = logging.getLogger(__name__)

TURN_S = 0.2
"""How often nodes that come and go are logged."""
OPEN_TO_ALL = "tcp/0.0.0.0:7447"


@dataclass(frozen=True, slots=True)
class RouterSettings:
    """What the router is to do."""

    listen: tuple[str, ...] = ()
    """Endpoints to listen on; empty: those of `config`."""
    connect: tuple[str, ...] = ()
    """Other routers, or services that it shall reach."""
    config: str = ""
    """A Zenoh configuration (JSON5), for TLS and access control."""


def route(settings: RouterSettings) -> None:
    """Run a router until Ctrl-C or SIGTERM. Raises `UserError`."""
    if not settings.listen and not settings.config:
        raise UserError(
            f"router: name an address to listen on, such as --listen {OPEN_TO_ALL} (every network "
            "of this machine), or a Zenoh configuration"
        )
    stopped = threading.Event()
    stop_on_signals(stopped.set)
    zenoh.try_init_log_from_env()  # RUST_LOG=zenoh=info says who is refused, and why
    wanted = ZenohSettings(listen=settings.listen, connect=settings.connect, config=settings.config)
    session, connections = open_session(
        wanted, "router", "name another one with --listen, or correct the configuration"
    )
    nodes = session.liveliness().declare_subscriber(wire.liveliness_key(wire.ANY), history=True)
    try:
        log.info("zenoh router at %s", ", ".join(_locators(session)))
        if connections.endpoints:
            log.info("connects to %s", ", ".join(connections.endpoints))
        log.info("ready; Ctrl-C ends")
        while not stopped.wait(TURN_S):
            _log_nodes(nodes)
            _ = connections.missing  # logs each change
    finally:
        nodes.undeclare()
        session.close()


def _locators(session: zenoh.Session) -> list[str]:
    """Return the addresses at which it listens, from its own report."""
    for reply in session.get(f"@/{session.zid()}/router", timeout=1.0):
        if reply.ok is not None:
            return [str(each) for each in json.loads(reply.ok.payload.to_bytes())["locators"]]
    return []


def _log_nodes(nodes: zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]) -> None:
    while (sample := nodes.try_recv()) is not None:
        node = str(sample.key_expr).split("/")[2]
        there = sample.kind == zenoh.SampleKind.PUT
        log.info("%s %s", node, "is connected" if there else "has left")
