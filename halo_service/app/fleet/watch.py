"""Receives what all nodes report: one Zenoh client for each router or node, and mDNS.

Rule: callbacks of Zenoh only append to a bounded queue, with the time of arrival.
"""

from __future__ import annotations

import logging
import re
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import ExitStack, closing
from typing import NamedTuple

import zenoh

import halo_protocol as wire
from halo_client import ClientError, ZenohSource
from halo_client.zenoh_input import ZenohInput
from halo_service.app.discovery import MdnsSearch, Service
from halo_service.app.fleet.fleet import Fleet
from halo_service.app.fleet.node import Node, Versions
from halo_service.app.versions import service_version, zenoh_version
from halo_service.errors import UserError
from halo_service.files import from_home
from halo_service.host_clock import CLOCK
from halo_service.outputs.settings import LISTEN, ZenohSettings

log = logging.getLogger(__name__)

KEYS = ("halo/*/*/*/scene", wire.zenoh_key(wire.ANY, wire.ANY, "health"))
"""Scenes of all major versions."""
MOST_WAITING = 10_000
MDNS_S = 2.0
"""How often mDNS is asked."""
EVERYWHERE = re.compile(r"^(\w+)/(0\.0\.0\.0|\[::\]):")


class _Arrival(NamedTuple):
    key: str
    payload: bytes | None
    """None: of a liveliness token."""
    alive: bool
    unix_us: int
    now_s: float


class FleetWatch:
    """Watches until it is closed."""

    def __init__(self, sources: Sequence[ZenohSource], *, mdns: bool = True) -> None:
        """Raises `UserError` for a source that can never open."""
        self._waiting: deque[_Arrival] = deque(maxlen=MOST_WAITING)
        self._fleet = Fleet(Versions(wire.VERSION, service_version(), zenoh_version()))
        self._services: list[Service] | None = None
        """Announced ones, until `nodes` has read them."""
        self._ended = threading.Event()
        self._stack = ExitStack()
        try:
            for source in sources:
                self._stack.enter_context(closing(ZenohInput(source, self._subscribe)))
        except ClientError as error:
            self._stack.close()
            raise UserError(f"list: {error}") from error
        if mdns:
            search = threading.Thread(target=self._search, name="fleet mdns", daemon=True)
            search.start()
            self._stack.callback(search.join)
            self._stack.callback(self._ended.set)

    def nodes(self) -> list[Node]:
        """Return what is known now; of one thread."""
        while self._waiting:
            each = self._waiting.popleft()
            if each.payload is None:
                self._fleet.token(each.key, alive=each.alive, now_s=each.now_s)
            else:
                self._fleet.sample(each.key, each.payload, each.unix_us, each.now_s)
        if self._services is not None:
            services, self._services = self._services, None
            self._fleet.announced(services, time.monotonic())
        return self._fleet.nodes(time.monotonic(), CLOCK.unix_us() / 1e6)

    def close(self) -> None:
        """Close all sessions."""
        self._stack.close()

    def _search(self) -> None:
        """Look for announcements until the end."""
        try:
            search = MdnsSearch()
        except UserError as error:
            log.warning("%s", error)
            return
        with closing(search):
            while not self._ended.wait(MDNS_S):
                self._services = search.services()

    def _subscribe(self, session: zenoh.Session) -> list[zenoh.Subscriber[None]]:
        def store(sample: zenoh.Sample) -> None:
            self._store(sample, sample.payload.to_bytes())

        token = wire.liveliness_key(wire.ANY)
        return [
            *(session.declare_subscriber(key, store) for key in KEYS),
            session.liveliness().declare_subscriber(token, self._store, history=True),
        ]

    def _store(self, sample: zenoh.Sample, payload: bytes | None = None) -> None:
        alive = sample.kind == zenoh.SampleKind.PUT
        key, unix_us = str(sample.key_expr), CLOCK.unix_us()
        self._waiting.append(_Arrival(key, payload, alive, unix_us, time.monotonic()))


def sources(zenoh: ZenohSettings, connect: Sequence[str] = ()) -> list[ZenohSource]:
    """Return where to look: `connect`, else the routers of the settings and this machine's service.

    Each is a client of its own, as a router passes nothing from one peer to another.
    """
    if not (zenoh.enabled or connect):
        return []
    config = str(from_home(zenoh.config)) if zenoh.config else ""
    if zenoh.multicast and not connect:
        return [ZenohSource(zenoh.connect, multicast=True, mode="peer", config=config)]
    local = zenoh.listen or (() if config else LISTEN)
    places = tuple(connect) or (*zenoh.connect, *map(_reachable, local))
    return [
        ZenohSource((each,) if each else (), mode="client", config=config)
        for each in dict.fromkeys(places or ("",))
    ]


def _reachable(listen: str) -> str:
    """Return where a peer is reached that listens on all addresses of this machine."""
    here = {"0.0.0.0": "127.0.0.1", "[::]": "[::1]"}
    return EVERYWHERE.sub(lambda found: f"{found[1]}/{here[found[2]]}:", listen)
