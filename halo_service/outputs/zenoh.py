"""The same bytes as Zenoh samples, from a peer inside the service.

Keys: `halo/1/{node}/{surface}/{kind}`; a liveliness token announces the node; queries for
scene, homography and pose get the latest one.
"""

from __future__ import annotations

import json
import logging
import re
import time
from typing import Any

import zenoh

import halo_protocol as wire
from halo_client.interfaces import multicast_interface
from halo_protocol.names import ZENOH_KINDS
from halo_service.errors import UserError
from halo_service.files import from_home
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import Outgoing
from halo_service.outputs.settings import LISTEN, ZenohSettings

log = logging.getLogger(__name__)

RETRY = {"period_init_ms": 250, "period_max_ms": 500}
RETAINED = ("scene", "homography", "pose")


class ZenohOutput:
    """An embedded Zenoh peer that publishes one surface of one node."""

    def __init__(
        self, settings: ZenohSettings, node: str, surface: str, names: NameWatch | None = None
    ) -> None:
        """Open the peer; `names` gets the scenes that others publish under this node's name.

        Raises `UserError` when it cannot listen or connect.
        """
        self._session, self._connect = _open(settings)
        self._away: list[str] = []
        self._last: dict[str, bytes] = {}
        self._publishers: dict[str, zenoh.Publisher] = {}
        for kind in ZENOH_KINDS:
            key = wire.zenoh_key(node, surface, kind)
            self._publishers[kind] = self._session.declare_publisher(
                key,
                congestion_control=zenoh.CongestionControl.DROP,
                priority=zenoh.Priority.REAL_TIME if kind == "frame" else zenoh.Priority.DATA,
                express=True,
            )
        self._queryables = [self._answer(wire.zenoh_key(node, surface, k), k) for k in RETAINED]
        self._others = None if names is None else self._subscribe_to_others(node, names)
        self._token = self._session.liveliness().declare_token(wire.liveliness_key(node))

    @property
    def missing(self) -> int:
        """Number of the endpoints to connect to without a connection; Zenoh tries them again."""
        linked = {_protocol_and_port(link.dst) for link in self._session.info.links()}
        away = [each for each in self._connect if _protocol_and_port(each) not in linked]
        for each in away if away != self._away else ():
            log.warning("zenoh: no connection to %s; trying again until it answers", each)
        if self._away and not away:
            log.warning("zenoh: connected to %s", ", ".join(self._connect))
        self._away = away
        return len(away)

    def send(self, outgoing: Outgoing) -> None:
        """Put each datagram as one sample."""
        if outgoing.kind in RETAINED:
            self._last[outgoing.kind] = outgoing.datagrams[-1]
        for datagram in outgoing.datagrams:
            self._publishers[outgoing.kind].put(datagram)

    def close(self) -> None:
        """Undeclare everything, then close: closing first can hang."""
        self._token.undeclare()
        if self._others is not None:
            self._others.undeclare()
        for queryable in self._queryables:
            queryable.undeclare()
        for publisher in self._publishers.values():
            publisher.undeclare()
        self._session.close()

    def _subscribe_to_others(self, node: str, names: NameWatch) -> zenoh.Subscriber[None]:
        """Receive scenes of this node's name that are not ours."""

        def look(sample: zenoh.Sample) -> None:
            names.datagram(sample.payload.to_bytes(), time.monotonic())

        key = wire.zenoh_key(node, wire.ANY, "scene")
        return self._session.declare_subscriber(key, look, allowed_origin=zenoh.Locality.REMOTE)

    def _answer(self, key: str, kind: str) -> zenoh.Queryable[None]:
        def reply(query: zenoh.Query) -> None:
            retained = self._last.get(kind)
            if retained is not None:
                query.reply(key, retained)

        return self._session.declare_queryable(key, reply)


def _open(settings: ZenohSettings) -> tuple[zenoh.Session, list[str]]:
    """Open a session; return it, and the endpoints to which it connects."""
    config = _base_config(settings.config)
    try:
        config.insert_json5("mode", json.dumps("peer"))
        _fill(config, "listen/endpoints", settings.listen, LISTEN)
        _fill(config, "connect/endpoints", settings.connect, ())
        _fill(config, "scouting/multicast/enabled", settings.multicast, False)
        _fill(config, "scouting/multicast/interface", None, multicast_interface())
        # Zenoh's own limit is 10 s for each address of a peer that cannot be reached.
        _fill(config, "transport/unicast/open_timeout", None, 1000)
        # A router that starts later, or again, is found soon.
        _fill(config, "connect/retry", None, RETRY)
        return zenoh.open(config), _connects(config)
    except zenoh.ZError as error:
        listen, connect = (_endpoints(config, key) for key in ("listen", "connect"))
        raise UserError(
            f"zenoh: cannot listen at {', '.join(settings.listen) or listen} or connect to "
            f"{', '.join(settings.connect) or connect} ({_reason(error)}); another service or "
            f"router may have the port: set [zenoh] listen or connect, or start with --no-zenoh"
        ) from error


def _base_config(path: str) -> zenoh.Config:
    """Read the user's Zenoh configuration; without one, Zenoh's defaults."""
    if not path:
        return zenoh.Config()
    try:
        return zenoh.Config.from_file(from_home(path))
    except zenoh.ZError as error:
        raise UserError(
            f"zenoh: the configuration {path} cannot be read ({_reason(error)}); "
            f"correct [zenoh] config, or leave it out"
        ) from error


def _fill(config: zenoh.Config, key: str, value: Any, default: Any) -> None:
    """Set the user's value, else keep the value of the file, else set our default.

    Zenoh fills in missing values, so a value equal to Zenoh's default counts as not set.
    """
    if value or config.get_json(key) == zenoh.Config().get_json(key):
        config.insert_json5(key, json.dumps(value or default))


def _connects(config: zenoh.Config) -> list[str]:
    endpoints = json.loads(config.get_json("connect/endpoints"))
    return [each for each in endpoints if isinstance(each, str)] if endpoints else []


def _protocol_and_port(locator: str) -> tuple[str, str]:
    """Return what a link and its endpoint have in common: its host may be a name."""
    address = re.split(r"[?#]", locator)[0]
    return address.partition("/")[0], address.rpartition(":")[2]


def _endpoints(config: zenoh.Config, key: str) -> str:
    return config.get_json(f"{key}/endpoints").strip("[]").replace('"', "") or "nothing"


def _reason(error: zenoh.ZError) -> str:
    """Zenoh's error text without the position in Zenoh's source code."""
    words = re.sub(r"\s*\bat \S+\.rs:\d+\.?", "", str(error)).strip()
    inner = re.search(r'msg: "(.*?)", location', words)
    return inner[1] if inner else words.splitlines()[-1].strip(" =")
